"""The simulation: an interpreter of the actions of explorers, over a discrete-event clock."""
