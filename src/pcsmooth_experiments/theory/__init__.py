"""What chapter 4 of the thesis proves, measured."""
