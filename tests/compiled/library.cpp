// A library needs a file of its own beside the one that compiles insonify.
int library_version() { return 1; }
