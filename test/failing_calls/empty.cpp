// A library under the name of another one, in which there is nothing.
