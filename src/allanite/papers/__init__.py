"""What papers print, and what the program finds instead: one file a paper."""
