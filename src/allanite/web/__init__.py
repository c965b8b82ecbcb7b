"""The page in the browser: everything that the command line does, on this machine alone."""
