"""PyTorch foundations: devices, precision, memory layout, optimizer state, seeding."""
