// A target has a source; what it is for is the library that it makes loadable.
