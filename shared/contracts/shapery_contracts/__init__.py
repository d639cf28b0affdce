"""Job kinds, parameters, results, states, error codes and file formats that every part of Shapery agrees on."""
