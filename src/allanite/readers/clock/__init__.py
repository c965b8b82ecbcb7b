"""From stamps to a sampling rate and lost samples."""
