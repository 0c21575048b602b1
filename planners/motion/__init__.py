"""How a body gets from one configuration to another, and how long that takes."""
