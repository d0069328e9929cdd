//! What the tests of the whole share: where the built command and the FMU lie.
