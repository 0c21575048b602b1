"""Sensor-based Random Trees: how an explorer builds its tree."""
