"""`python -m uavftc`: the umbrella command."""

from uavftc.cli.app import main

if __name__ == "__main__":
    main()
