#ifndef INSONIFY_TESTS_COMPILED_PICTURES_HPP
#define INSONIFY_TESTS_COMPILED_PICTURES_HPP

#include <insonify/insonify.hpp>

/// Some objects under a probe.
insonify::scene make_body();

/// What the library compiles once: the picture of a probe, and the same by its stages.
insonify::image picture_of_linear_array(const insonify::scene& body);
insonify::image stages_of_linear_array(const insonify::scene& body);

/// The same picture by a probe that is another type, compiled where it is called.
insonify::image picture_of_own_probe(const insonify::scene& body);

/// Echoes of a model that is another type: a tenth of those of `physical`.
insonify::iq_lines echoes_of_physical(const insonify::scene& body);
insonify::iq_lines echoes_of_own_model(const insonify::scene& body);

#endif
