"""What `python -m multisrt` runs."""

from multisrt.cli import main

if __name__ == "__main__":
    main()
