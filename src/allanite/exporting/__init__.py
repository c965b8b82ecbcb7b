"""From identified noise to the file of a filter or simulator, and back."""
