"""What `python -m multisrt.cli` runs."""

from multisrt.cli import main

if __name__ == "__main__":
    main()
