#include <insonify/channels/channel_data.hpp>
#include <cmath>
#include <complex>
#include <cstddef>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

TEST_CASE("demodulate: the envelope and the phase of a pulse, whatever its lane") {
    channel_data data;
    data.transmits = 3;
    data.elements = 7;
    data.samples = 400;
    data.sampling_frequency = 30e6F;
    data.start = 1e-6F;
    data.frequency = 7.5e6F;
    data.places.resize(7);
    data.sent.assign(3, transmit{.delays = std::vector<float>(7, 0)});
    data.values.resize(3 * 7 * 400);
    const auto envelope_at = [&](std::uint32_t channel, double time) {
        const double from = time - 6e-6 - 0.1e-6 * channel;
        return (1 + 0.1 * channel) * std::exp(-from * from / (2 * 0.2e-6 * 0.2e-6));
    };
    const auto phase_of = [](std::uint32_t channel) { return 0.3 * channel; };
    const auto time_of = [&](std::uint32_t k) { return 1e-6 + k / 30e6; };
    for (std::uint32_t c = 0; c < 21; ++c)
        for (std::uint32_t k = 0; k < 400; ++k)
            data(c / 7, c % 7, k) = static_cast<float>(
                envelope_at(c, time_of(k)) * std::cos(2 * 3.141592653589793 * 7.5e6 * time_of(k) + phase_of(c)));
    const iq_channel_data iq = demodulate(exec::par, data);
    CHECK(iq.sampling_frequency == data.sampling_frequency);
    double worst = 0;
    for (std::uint32_t c = 0; c < 21; ++c)
        for (std::uint32_t k = 0; k < 400; ++k) {
            const std::complex<double> expected = std::polar(envelope_at(c, time_of(k)), phase_of(c));
            const vec2 found = iq(c / 7, c % 7, k);
            worst = std::max(worst, std::abs(expected - std::complex<double>{found.x, found.y}));
        }
    CHECK(worst < 2e-3);
    CHECK(iq == demodulate(exec::seq, data));
}
