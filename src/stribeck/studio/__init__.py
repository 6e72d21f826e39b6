"""The studio: a local page that goes from a drive's file to a report and to code for a controller.

It computes nothing itself: what it shows is read, identified and exported by the public functions
of the package. `serve` starts it.
"""
