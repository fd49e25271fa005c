// A target has a source; what it is for is its precompiled headers.
