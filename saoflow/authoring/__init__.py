"""Help for those who write sheets: what a diagnosis means, a schema for editors, a formatter, first sheets, differences."""
