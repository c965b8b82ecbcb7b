"""Words: sentences that are translated when they are shown, plurals, shares and options."""
