"""The truth at work: an interpreter of what explorers want done, over a discrete-event clock."""
