"""The virtual gonioreflectometer, with which tone tables are measured."""
