"""`python -m uavftc`: the umbrella command."""

from uavftc.cli.entry import main

if __name__ == "__main__":
    main()
