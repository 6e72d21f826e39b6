"""A fit as one page that needs no network: its tables, and the script that draws its plots."""
