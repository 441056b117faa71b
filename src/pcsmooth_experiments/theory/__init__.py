"""What chapter 4 of the report proves, measured."""
