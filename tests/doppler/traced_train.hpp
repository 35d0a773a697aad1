#ifndef INSONIFY_TESTS_DOPPLER_TRACED_TRAIN_HPP
#define INSONIFY_TESTS_DOPPLER_TRACED_TRAIN_HPP

#include <insonify/doppler/doppler_ensemble.hpp>
#include <insonify/probe/linear_array.hpp>

namespace doppler_test {

/// The echoes of a pulse train before pulse and beam.
template <class Field>
insonify::detail::ensemble_echoes traced(const insonify::scene& body, const insonify::linear_array& probe,
                                         const Field& field, const insonify::acquisition& scan,
                                         const insonify::detail::pulse_train& pulses) {
    insonify::detail::ensemble_echoes echoes;
    insonify::detail::ensemble_tracer<insonify::linear_array>{}.trace(
        insonify::detail::any_policy{insonify::exec::par_unseq}, body, probe, {}, {}, field, scan, pulses, echoes);
    return echoes;
}

} // namespace doppler_test

#endif
