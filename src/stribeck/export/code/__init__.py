"""The law as source code of a controller: its program, and one file a language."""
