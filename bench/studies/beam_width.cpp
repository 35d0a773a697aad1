#include <insonify/core/units.hpp>
#include <insonify/signal/pulse.hpp>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <vector>

/// How far `beam_model::lateral_width` is from simulated fields: a pulse of 2.5 cycles from an array with one transmit focus, which
/// receives at constant F-number, focused at each depth. The width is that of the envelope's peak across the line, at -6 dB.
/// 3.5 to 7.5 MHz, F/2 to F/4, foci of 20 to 40 mm, depths of 0.4 to 2.2 times the focus.
namespace {

using namespace insonify;
using complex = std::complex<double>;

constexpr double two_pi = 6.283185307179586, speed = display_speed;
constexpr int frequencies = 25;

/// The field at a point of an aperture of this width that is focused at a depth, at one frequency: Rayleigh's integral over sources
/// half a wavelength apart.
complex field(double x, double z, double width, double focus, double frequency) {
    const double k = two_pi * frequency / speed;
    const int sources = std::max(8, static_cast<int>(2 * width * frequency / speed));
    complex sum{};
    for (int i = 0; i < sources; ++i) {
        const double from = width * ((i + 0.5) / sources - 0.5);
        const double path = std::hypot(x - from, z), sooner = std::hypot(from, focus) - focus;
        sum += std::polar(1 / (std::sqrt(path) * sources), k * (sooner - path + z));
    }
    return sum;
}

/// The peak of the envelope that a point at x, z returns.
double echo(double x, double z, double carrier, double fnumber, double focus) {
    const double sigma = static_cast<double>(pulse{}.bandwidth()) * carrier / 2.3548; // of the spectrum
    complex spectrum[frequencies];
    for (int i = 0; i < frequencies; ++i) {
        const double sigmas = 6.0 * i / (frequencies - 1) - 3, frequency = carrier + sigmas * sigma;
        spectrum[i] = std::exp(-0.5 * sigmas * sigmas) * field(x, z, focus / fnumber, focus, frequency) *
                      field(x, z, z / fnumber, z, frequency);
    }
    double largest = 0;
    for (double time = -2; time < 2; time += 0.05) { // periods
        complex sum{};
        for (int i = 0; i < frequencies; ++i)
            sum += spectrum[i] * std::polar(1.0, two_pi * time / carrier * (6.0 * i / (frequencies - 1) - 3) * sigma);
        largest = std::max(largest, std::abs(sum));
    }
    return largest;
}

double simulated_width(double z, double carrier, double fnumber, double focus) {
    const double step = 0.05 * speed / carrier * fnumber, half = 0.5 * echo(0, z, carrier, fnumber, focus);
    double before = 2 * half;
    for (double x = step;; x += step) {
        const double here = echo(x, z, carrier, fnumber, focus);
        if (here < half) return 2 * (x - step * (half - here) / (before - here));
        before = here;
    }
}

} // namespace

int main() {
    std::vector<double> errors;
    for (const float carrier : {3.5_MHz, 5_MHz, 7.5_MHz})
        for (const float fnumber : {2.0F, 3.0F, 4.0F})
            for (const float focus : {20_mm, 30_mm, 40_mm}) {
                const beam_model beam{.wavelength = display_speed / carrier, .min_fnumber = fnumber, .focus = focus};
                for (int i = 0; i < 19; ++i) {
                    const float z = focus * (0.4F + 0.1F * static_cast<float>(i));
                    const double expected = simulated_width(static_cast<double>(z), static_cast<double>(carrier),
                                                            static_cast<double>(fnumber), static_cast<double>(focus));
                    errors.push_back(static_cast<double>(beam.lateral_width(z)) / expected - 1);
                }
            }
    const auto within = [&](double limit) {
        const auto fits = [=](double error) { return std::fabs(error) <= limit; };
        return 100.0 * static_cast<double>(std::count_if(errors.begin(), errors.end(), fits)) /
               static_cast<double>(errors.size());
    };
    const auto [smallest, highest] = std::minmax_element(errors.begin(), errors.end());
    std::printf("%zu widths: %.1f %% within 5 %%, %.1f %% within 10 %%, from %+.1f to %+.1f %%\n", errors.size(),
                within(0.05), within(0.1), 100 * *smallest, 100 * *highest);
}
