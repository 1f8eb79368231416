"""Controllers from outside: a file, a module or an entry point."""
