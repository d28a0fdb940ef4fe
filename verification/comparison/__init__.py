"""Sheets and variants side by side: accuracy and detection on the same flights, against operations and time."""
