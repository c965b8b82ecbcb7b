"""Many units: the same analysis of many files, held against limits, with mean, spread and worst over all of them."""
