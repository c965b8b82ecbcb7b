"""From time stamps to a sampling rate and missing samples."""
