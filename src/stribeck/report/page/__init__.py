"""A fit as one page that needs no network, and the file it is made from."""
