"""Tests of the engine; a package, so that helpers have the same name in any working directory."""
