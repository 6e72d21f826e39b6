"""From a file to a `Recording`: a reader a format, columns to channels, repairs that are told."""
