"""Sheets and their variants side by side: accuracy and detection on the same flights, against operations and time a frame."""
