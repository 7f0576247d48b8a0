"""Tests as claims; a package, so that helpers have one name whatever the working directory."""
