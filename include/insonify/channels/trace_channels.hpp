#ifndef INSONIFY_CHANNELS_TRACE_CHANNELS_HPP
#define INSONIFY_CHANNELS_TRACE_CHANNELS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/physical.hpp>
#include <insonify/bvh/large_array.hpp>
#include <insonify/channels/arriving_waves.hpp>
#include <insonify/channels/channel_data.hpp>
#include <insonify/channels/element_array.hpp>
#include <insonify/channels/element_fans.hpp>
#include <insonify/channels/element_field.hpp>
#include <insonify/channels/pair_sums.hpp>
#include <insonify/channels/reflectors.hpp>
#include <insonify/channels/transmit.hpp>
#include <insonify/channels/wave_fronts.hpp>
#include <insonify/channels/zones.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/signal/fourier.hpp>
#include <insonify/signal/pulse.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// How channel data are made.
struct channel_settings {
    float depth = 0.04F;           ///< to be recorded, metres
    float sampling_frequency = 0;  ///< of RF, hertz; 0: four times the carrier
    float opening = 20 * pi / 180; ///< beyond the ends of the array: the slice that is covered, radians
    bool speckle = true;           ///< scatterers of tissue
    bool surfaces = true;          ///< echoes of surfaces
    /// Each transmit is one wave front instead of the sum of the waves of all elements: faster, without the waves from
    /// the ends of the aperture.
    bool wave_fronts = false;
    float noise_level_db = no_level_db; ///< of electronic noise, independent from element to element, rms; 0 dB is 1
    std::uint32_t noise_seed = 1;       ///< selects its realization
    std::uint32_t frame = 0;            ///< number of the frame: noise and the speckle of flowing media change with it
    std::uint64_t max_memory = std::uint64_t{4} << 30U; ///< bytes, of what is returned and of what it takes
    std::span<const point_scatterer> points{};          ///< scatterers of one's own, beside those of tissue
};

namespace detail {

/// Sampling of a record.
struct record_plan {
    float rate = 0;            // of RF, hertz
    std::uint32_t samples = 0; // of RF
    std::uint32_t halves = 2;  // RF samples for each two complex ones: 2^n or 3 * 2^n
    std::uint32_t margin = 0;  // complex samples before time 0
    std::uint32_t length = 0;  // complex samples with margins
    std::size_t transform = 0; // length of the transform of them
    float sigma_time = 0;      // of the pulse's envelope, s
    float sigma_frequency = 0; // of its amplitude spectrum, hertz
    float node_step = 0;       // see `spectral_value`, hertz

    float complex_rate() const { return 2 * rate / static_cast<float>(halves); }
};

/// Frequencies, relative to the carrier, at which the spectra of pairs are kept.
struct band {
    std::vector<std::uint32_t> bins{}; // of the transform
    std::vector<float> offsets{};      // hertz
    std::vector<float> filter{};       // the pulse's spectrum, and the inverse of the B-spline's
};

template <class Model>
concept reflects_everything = requires(const Model& m, const medium& one, const incidence& at) {
    { m.at_interface(at) } -> std::same_as<response>;
    { m.loss(one, 1e6F) } -> std::convertible_to<float>;
    m.with_boundary(transparent{}).with_attenuation(lossless{});
    m.roughness.coherent(at);
};

/// The work of `trace_channels`, for arrays as data.
template <class Model>
class channel_tracer {
  public:
    /// @param threads  see `exec::max_threads`
    channel_tracer(const scene& body, const pose& at, const Model& model, const channel_settings& settings,
                   std::uint32_t threads)
        : body_{body}, at_{at}, model_{model}, settings_{settings}, threads_{threads} {}

    // Everything but places and samples is set in `out`.
    template <class Policy>
    void run(const Policy& policy, float fnumber, channel_data& out) {
        frequency_ = out.frequency;
        elements_ = out.elements;
        width_ = out.element_width;
        height_ = out.height;
        plan(out);
        make_band();
        find_reflectors(policy, fnumber, out);
        receive(policy, settings_.wave_fronts ? pair_spectra<true>(policy, out) : pair_spectra<false>(policy, out),
                out);
        add_noise(policy, out);
    }

  private:
    void plan(channel_data& out) {
        const float bandwidth = out.bandwidth;
        record_.rate = settings_.sampling_frequency != 0 ? settings_.sampling_frequency : 4 * frequency_;
        if (!is_finite(record_.rate) || !(record_.rate >= frequency_ * (2 + bandwidth)) || !(record_.rate <= 1e10F))
            throw usage_error{"trace_channels: sampling_frequency is ", 1e-6F * record_.rate,
                              " MHz; the band of the array ends at ", 1e-6F * frequency_ * (1 + 0.5F * bandwidth),
                              " MHz: sample at twice that or more, or leave it at 0"};
        record_.sigma_frequency = bandwidth * frequency_ / 2.3548F;
        // So few complex samples that half of their rate is 3.5 standard deviations of the spectrum: -53 dB.
        const float slowest = max(2.5F * frequency_, 7 * record_.sigma_frequency);
        for (std::uint32_t next = 3; 2 * record_.rate / static_cast<float>(next) >= slowest;
             next = next % 3 == 0 ? next / 3 * 4 : next / 2 * 3)
            record_.halves = next;
        record_.node_step = spectral_value::step(record_.sigma_frequency, frequency_);
        record_.sigma_time = 1 / (2 * pi * record_.sigma_frequency);
        float max_delay = 0;
        for (const transmit& one : out.sent)
            for (std::uint32_t i = 0; i < elements_; ++i)
                if (one.weight(i) != 0) max_delay = max(max_delay, one.delays[i]);
        const float aperture = length(out.places.back().origin - out.places.front().origin);
        // From below one end of the array to the other.
        const float longest = std::sqrt(settings_.depth * settings_.depth + aperture * aperture);
        const float seconds = (settings_.depth + longest) / out.sound_speed + max_delay;
        record_.samples = static_cast<std::uint32_t>(std::ceil(seconds * record_.rate));
        const float rate = record_.complex_rate();
        record_.margin = 4 + 2 * static_cast<std::uint32_t>(std::ceil(3 * record_.sigma_time * rate)); // even
        // Pair sums end where no delay has been added yet.
        record_.length = static_cast<std::uint32_t>(std::ceil(seconds * rate)) + 2 * record_.margin;
        record_.transform = transform_length(record_.length);
        out.sampling_frequency = record_.rate;
        out.samples = record_.samples;
        out.start = 0;

        pairs_ = {settings_.wave_fronts ? out.transmits : elements_, elements_, !settings_.wave_fronts};
    }

    // Bytes at their peak, with what is returned, beside the scene. @param reflectors  of all kinds
    std::uint64_t memory(const channel_data& out, std::uint64_t reflectors) const {
        const std::size_t nodes = settings_.wave_fronts ? wave_fronts::nodes : spectral_value::nodes;
        const std::uint64_t channels = std::uint64_t{out.transmits} * elements_, pairs = pairs_.count();
        const std::uint64_t records = channels * record_.samples * sizeof(float),
                            spectra = pairs * band_.bins.size() * sizeof(vec2),
                            sums = pairs * record_.length * nodes * sizeof(vec2);
        const std::uint64_t tables =
            settings_.wave_fronts
                ? (out.transmits + elements_) * std::uint64_t{wave_table<wave_fronts::nodes>::bytes_per_column()}
                : elements_ * std::uint64_t{wave_table<spectral_value::nodes>::bytes_per_column()};
        const std::uint64_t sorting = reflectors * (2 * sizeof(reflector) + 2 * sizeof(zone_key)),
                            summing =
                                sums + tables + transforms(pairs, complex_batch::width / nodes, record_.transform),
                            receiving = records + transforms(channels, complex_batch::width,
                                                             record_.transform * record_.halves / 2),
                            tracing = reflectors * sizeof(reflector) + spectra + std::max(summing, receiving);
        constexpr std::uint64_t small = 8U << 20U;               // tables and the like
        const std::uint64_t sent = channels * 5 * sizeof(float); // delays and weights, and those of wave fronts
        return fans_.bytes() + field_.bytes() + sent + small + std::max(sorting, tracing);
    }
    // Of blocks of channels, one on each thread. @param together  channels of a block
    std::uint64_t transforms(std::uint64_t channels, std::uint64_t together, std::uint64_t length) const {
        const std::uint64_t blocks = std::min<std::uint64_t>(threads_, (channels + together - 1) / together);
        return blocks * 2 * length * sizeof(complex_block);
    }

    /// @param found  what is known of layers and reflectors: all, or "at least " these
    /// @throws usage_error  for more than `max_memory`
    void check_memory(const channel_data& out, std::uint64_t reflectors, const char* found) const {
        if (const std::uint64_t bytes = memory(out, reflectors); bytes > settings_.max_memory)
            throw usage_error{"trace_channels: ",
                              out.transmits,
                              " transmits of ",
                              elements_,
                              " elements, ",
                              record_.samples,
                              " samples each, take ",
                              found,
                              1e-9F * static_cast<float>(bytes),
                              " GB, more than `max_memory` (",
                              1e-9F * static_cast<float>(settings_.max_memory),
                              " GB); lower depth, transmits or elements, or raise it"};
    }

    template <class Policy>
    void find_reflectors(const Policy& policy, float fnumber, const channel_data& out) {
        reflector_search<Model> search{
            body_,           out.places,       at_, model_, frequency_, out.bandwidth, record_.node_step,
            settings_.depth, settings_.opening};
        constexpr float long_search = 1e7F; // takes a second: what is too much without its tissue is refused before
        if (search.size() > long_search) check_memory(out, settings_.points.size(), "at least ");
        float highest = 0, highest_element = 0, lateral = 0;
        std::vector<reflector>& all = reflectors_;
        for (const point_scatterer& one : settings_.points) {
            const vec3 local = at_.local_point(one.position);
            if (!is_finite(one.position) || !is_finite(one.scattering_length))
                throw usage_error{"trace_channels: a point scatterer is not finite; check `points`"};
            const ray& nearest = nearest_to(out.places, local);
            if (!is_in_front(nearest, local)) continue;
            highest = max(highest, std::fabs(local.y));
            lateral = max(lateral, length(local - nearest.origin));
        }
        for (const ray& one : out.places) highest_element = max(highest_element, std::fabs(one.origin.y));
        const float aperture = length(out.places.back().origin - out.places.front().origin);
        const float reach = aperture + max(settings_.depth * (1 + std::tan(settings_.opening)), lateral);
        const auto passed = [&](const medium& before, const medium& after, float cosine, float roughness) {
            return model_.at_interface({before, after, cosine, frequency_, roughness}).transmitted;
        };
        const auto loss = [&](const medium& m, float frequency) { return model_.loss(m, frequency); };
        const beam_model beam{.wavelength = display_speed / frequency_,
                              .elevation_height = height_,
                              .elevation_focus = out.elevation_focus};
        const auto strip = [&](float distance) { return 1.4142136F * beam.elevation_sigma(distance); }; // one way
        fans_.assign(policy, body_, out.places, at_, frequency_, reach, loss, passed, strip, settings_.max_memory);
        speed_ = fans_.speed_at_face(elements_ / 2);
        field_.assign(policy, frequency_, record_.node_step, height_, out.elevation_focus, speed_, reach,
                      highest + highest_element);
        const std::uint64_t left = settings_.max_memory - std::min(settings_.max_memory, fans_.bytes());
        std::uint64_t uncounted = 0;
        if (settings_.speckle) {
            const std::uint64_t max_count = left / sizeof(reflector),
                                found = search.add_speckle(
                                    policy, speckle_strength(fnumber, min(out.elevation_focus, reach)), fnumber,
                                    out.elevation_focus / height_, settings_.frame, height_,
                                    [&](float depth) { return field_.tissue(depth); }, max_count, all);
            if (found > max_count) uncounted = found;
        }
        if (settings_.surfaces) search.add_surfaces(policy, field_, all);
        check_memory(out, all.size() + settings_.points.size() + uncounted, "");
        add_points(out.places, all);
        zones_ = sort_into_zones(policy, all, fans_, out.places, record_.sigma_frequency);
    }

    static const ray& nearest_to(view<const ray> places, vec3 local) {
        return places[nearest_element(places, {local.x, local.z})];
    }
    // Of the face of the nearest element: before the flanks of a convex array, z is below 0.
    static bool is_in_front(const ray& nearest, vec3 local) {
        return dot(local - nearest.origin, nearest.direction) > 0;
    }

    void add_points(view<const ray> places, std::vector<reflector>& all) const {
        all.reserve(all.size() + settings_.points.size());
        for (const point_scatterer& one : settings_.points) {
            const vec3 local = at_.local_point(one.position);
            if (!is_in_front(nearest_to(places, local), local)) continue;
            const auto root = spectral_value::everywhere(square_root(vec2{one.scattering_length, 0}));
            all.push_back({.place = {local.x, local.z}, .y = local.y, .root = root});
        }
    }

    // Scattering lengths from levels of speckle: `medium::backscatter` states them for pictures, relative to a mirror
    // that returns 1. Where an aperture of F-number F focuses, out of the slice with Fy, speckle of n scatterers a
    // volume has
    //
    //     level^2 = n <L^2> integral |p|^2 dz  integral A^4 dx dy / (wavelength F Fy)^2,   A = 1 in the focus
    //
    // after the division by the number of elements (`beamform`). Scatterers of a model have the level^2 / integral
    // |p|^2 dz a metre of depth. Of elements that radiate g(u) at the place u of the aperture, -1/2 to 1/2,
    // integral A^4 dx = wavelength F integral (g * g)^2 ds, with the autocorrelation g * g: 2/3 for g = 1.
    // @param focus  out of the slice, metres; of a lens that focuses beyond what is recorded, or of none, the end of that
    float speckle_strength(float fnumber, float focus) const {
        constexpr int places = 64;
        float sum = 0, weights = 0;
        for (int node = 0; node < spectral_value::nodes; ++node) {
            const float x = spectral_value::steps(node) * record_.node_step / record_.sigma_frequency;
            const float frequency = frequency_ + spectral_value::steps(node) * record_.node_step;
            float radiated[places];
            for (int i = 0; i < places; ++i) {
                const float place = (static_cast<float>(i) + 0.5F) / places - 0.5F,
                            cosine = 1 / std::sqrt(1 + place * place / (fnumber * fnumber));
                const float half = pi * frequency * width_ * place / fnumber * cosine / speed_;
                radiated[i] = cosine * std::sqrt(cosine) * // to a tall reflector: cos / sqrt(r)
                              (std::fabs(half) < 1e-3F ? 1.0F : std::sin(half) / half);
            }
            float both = 0;
            for (int shift = 1 - places; shift < places; ++shift) {
                float product = 0;
                for (int i = std::max(0, shift); i < places + std::min(0, shift); ++i)
                    product += radiated[i] * radiated[i - shift];
                both += product * product;
            }
            const float weight = std::exp(-x * x); // the power of the pulse
            sum += weight * both / (places * places * places);
            weights += weight;
        }
        const float wavelength = speed_ / frequency_, elevation_fnumber = focus / height_;
        const vec2 both = field_.surface(field_.position(focus)).at_carrier();
        const float across = field_.tissue(focus) * dot(both, both) * dot(both, both) / std::pow(height_, 4.0F);
        return elevation_fnumber * std::sqrt(wavelength * fnumber / (sum / weights * across));
    }

    void make_band() {
        const std::size_t length = record_.transform;
        const float rate = record_.complex_rate(), step = rate / static_cast<float>(length);
        const float widest = min(0.5F * rate, 3.7F * record_.sigma_frequency); // -60 dB
        for (std::size_t i = 0; i < length; ++i) {
            const float offset =
                step * (i < length / 2 ? static_cast<float>(i) : static_cast<float>(i) - static_cast<float>(length));
            if (std::fabs(offset) > widest || frequency_ + offset <= 0) continue;
            const float x = offset / record_.sigma_frequency, turn = pi * offset / rate;
            const float sinc = std::fabs(turn) < 1e-3F ? 1.0F : std::sin(turn) / turn;
            // exp(-t^2 / 2 s^2), of amplitude 1, has the spectrum sqrt(2 pi) s exp(-x^2 / 2); a transform sums samples.
            const float pulse = std::sqrt(2 * pi) * record_.sigma_time * std::exp(-0.5F * x * x) * rate;
            // A transducer does not radiate at 0 Hz, where nothing is attenuated and a Gaussian would remain.
            const float low = min(4 * (frequency_ + offset) / frequency_, 1), radiated = low * low * (3 - 2 * low);
            band_.bins.push_back(static_cast<std::uint32_t>(i));
            band_.offsets.push_back(offset);
            band_.filter.push_back(radiated * pulse / (sinc * sinc * sinc) / static_cast<float>(length));
        }
    }

    // The spectra of all pairs at the frequencies of the band. @tparam Fronts  sources are wave fronts, not elements
    template <bool Fronts, class Policy>
    large_array<vec2> pair_spectra(const Policy& policy, const channel_data& out) const {
        constexpr int nodes = Fronts ? wave_fronts::nodes : spectral_value::nodes;
        constexpr std::size_t pairs_together = complex_batch::width / nodes;
        const arriving_waves<Model> waves{
            out.places, fans_, field_, body_.media(), model_, {frequency_, record_.node_step, width_, height_, speed_}};
        const std::size_t count = band_.bins.size(), sum_size = record_.length * floats_per_wave<nodes>;
        large_array<vec2> spectra(pairs_.count() * count);
        std::fill(spectra.begin(), spectra.end(), vec2{0, 0});
        large_array<float> sums(pairs_.count() * sum_size);
        const auto sum_of = [&](std::size_t source, std::size_t receiver) {
            return sums.data() + pairs_(source, receiver) * sum_size;
        };
        wave_table<nodes> received{elements_}, sent{Fronts ? out.transmits : 0};
        const wave_fronts fronts{Fronts ? view<const transmit>{out.sent} : view<const transmit>{}, elements_,
                                 frequency_, record_.node_step};
        const fourier transform{record_.transform};
        const float rate = record_.complex_rate(), margin = static_cast<float>(record_.margin);
        for (const zone& own : zones_) {
            exec::for_each_block(policy, pairs_.count(), 64, 0.3F * static_cast<float>(sum_size),
                                 [&](std::size_t begin, std::size_t end) {
                                     std::fill(sums.data() + begin * sum_size, sums.data() + end * sum_size, 0.0F);
                                 });
            for (std::size_t block = own.begin; block < own.end; block += wave_table<nodes>::block) {
                const std::size_t size = std::min(wave_table<nodes>::block, own.end - block);
                exec::for_each_block(policy, received.whole_groups(size), wave_table<nodes>::group,
                                     30 * static_cast<float>(elements_), [&](std::size_t begin, std::size_t end) {
                                         find_waves(waves, own.slope, block, size, begin, end, received);
                                         if constexpr (Fronts) fronts.find(received, sent, begin, end);
                                     });
                // In tiles of sources and receivers, whose waves stay in a cache.
                constexpr std::size_t tile = 8;
                const std::size_t source_tiles = (pairs_.sources + tile - 1) / tile,
                                  receiver_tiles = (elements_ + tile - 1) / tile;
                exec::for_each_block(policy, source_tiles * receiver_tiles, 1,
                                     3 * tile * tile * static_cast<float>(size), [&](std::size_t number, std::size_t) {
                                         const std::size_t source = number / receiver_tiles * tile,
                                                           first = number % receiver_tiles * tile,
                                                           end = std::min<std::size_t>(first + tile, elements_);
                                         for (std::size_t n = source; n < std::min(source + tile, pairs_.sources); ++n)
                                             for (std::size_t m = Fronts ? first : std::max(first, n); m < end; ++m)
                                                 add_echoes(Fronts ? sent : received, n, received, m, size, rate,
                                                            margin, sum_of(n, m), sum_of(n, std::min(m + 1, end - 1)),
                                                            record_.length);
                                     });
            }
            const std::vector<float> weights = weights_of(nodes, own.slope);
            exec::for_each_block(policy, pairs_.count(), pairs_together, 80 * static_cast<float>(record_.transform),
                                 [&](std::size_t begin, std::size_t end) {
                                     add_spectra<nodes>(sums.data() + begin * sum_size, end - begin, weights, transform,
                                                        spectra.data() + begin * count);
                                 });
        }
        return spectra;
    }

    // What arrives from all elements at some reflectors of a block of this size.
    template <int Nodes>
    void find_waves(const arriving_waves<Model>& waves, float slope, std::size_t block, std::size_t size,
                    std::size_t begin, std::size_t end, wave_table<Nodes>& to) const {
        // Some elements at a time, whose fans stay in a cache.
        for (std::size_t first = 0; first < elements_; first += max_simd_width) {
            for (std::size_t i = begin; i < std::min(end, size); ++i)
                waves.find(reflectors_[block + i], slope, first, to, i);
            for (std::size_t i = std::max(begin, size); i < end; ++i)
                for (std::size_t n = first; n < std::min<std::size_t>(first + max_simd_width, elements_); ++n)
                    to.clear(n, i);
        }
    }

    // RF from the spectra of pairs.
    template <class Policy>
    void receive(const Policy& policy, const large_array<vec2>& spectra, channel_data& out) const {
        out.values.assign(std::size_t{out.transmits} * elements_ * record_.samples, 0.0F);
        const std::size_t count = band_.bins.size();
        const std::size_t longer = record_.transform * record_.halves / 2;
        const fourier back{longer};
        std::vector<vec2> carrier(record_.samples);
        for (std::size_t k = 0; k < carrier.size(); ++k)
            carrier[k] = turned(double{frequency_} * static_cast<double>(k) / double{record_.rate});
        exec::for_each_block(
            policy, std::size_t{out.transmits} * elements_, complex_batch::width,
            2 * static_cast<float>(longer + count * elements_), [&](std::size_t begin, std::size_t end) {
                std::vector<complex_block> values(longer), room(longer);
                std::vector<vec2> whole(count);
                for (std::size_t i = begin; i < end; ++i) {
                    const std::size_t number = i / elements_, m = i % elements_;
                    const transmit& one = out.sent[number];
                    if (pairs_.symmetric) {
                        std::fill(whole.begin(), whole.end(), vec2{0, 0});
                        for (std::size_t n = 0; n < elements_; ++n) {
                            const float weight = one.weight(static_cast<std::uint32_t>(n));
                            if (weight == 0) continue;
                            add_delayed(spectra.data() + pairs_(std::min(n, m), std::max(n, m)) * count, weight,
                                        one.delays[n], whole);
                        }
                    } else {
                        const vec2* const own = spectra.data() + pairs_(number, m) * count;
                        std::copy(own, own + count, whole.begin());
                    }
                    for (std::size_t b = 0; b < count; ++b) {
                        const std::size_t bin = band_.bins[b];
                        complex_block& to =
                            values[bin < record_.transform / 2 ? bin : longer - (record_.transform - bin)];
                        to.x[i - begin] = whole[b].x;
                        to.y[i - begin] = whole[b].y;
                    }
                }
                back.inverse(values, room);
                const std::size_t offset = std::size_t{record_.margin} * record_.halves / 2;
                for (std::size_t k = 0; k < record_.samples; ++k) {
                    complex_block& sample = values[offset + k];
                    sample.store_from(batch_product(carrier[k], sample.loaded()));
                    for (std::size_t i = begin; i < end; ++i) out.values[i * record_.samples + k] = sample.x[i - begin];
                }
            });
    }

    void add_delayed(const vec2* spectrum, float weight, float delay, std::vector<vec2>& to) const {
        const std::size_t count = to.size();
        if (delay == 0) {
            for (std::size_t b = 0; b < count; ++b) to[b] += weight * spectrum[b];
            return;
        }
        // Bins follow one another but for the one after the highest frequency.
        const float step = record_.complex_rate() / static_cast<float>(record_.transform);
        const vec2 turn = turned(-double{step} * double{delay});
        vec2 factor{0, 0};
        for (std::size_t b = 0; b < count; ++b) {
            if (b % 64 == 0 || band_.bins[b] != band_.bins[b - 1] + 1)
                factor = weight * turned(-(double{frequency_} + double{band_.offsets[b]}) * double{delay});
            to[b] += complex_product(factor, spectrum[b]);
            factor = complex_product(factor, turn);
        }
    }

    // The share of each node in the spectrum of a pair, at each frequency of the band, filtered.
    std::vector<float> weights_of(int nodes, float zone_slope) const {
        std::vector<float> weights;
        for (std::size_t b = 0; b < band_.bins.size(); ++b) {
            const float filter = std::exp(-zone_slope * band_.offsets[b]) * band_.filter[b];
            // Held from 1.5 standard deviations on: a polynomial would grow without bound.
            const float place = clamp(band_.offsets[b] / record_.node_step, -2.5F, 2.5F);
            for (int node = 0; node < nodes; ++node)
                weights.push_back(filter * spectral_value::weight(node, nodes, place));
        }
        return weights;
    }

    // A node of a pair in each lane. @param pairs  no more than there are lanes for
    template <std::size_t Nodes>
    void add_spectra(const float* sums, std::size_t pairs, const std::vector<float>& weights, const fourier& transform,
                     vec2* to) const {
        constexpr std::size_t wave = floats_per_wave<Nodes>;
        const std::size_t sum_size = record_.length * wave, count = band_.bins.size();
        std::vector<complex_block> values(transform.size()), room(transform.size());
        for (std::size_t k = 0; k < record_.length; ++k)
            for (std::size_t p = 0; p < pairs; ++p) {
                const float* const sample = sums + p * sum_size + wave * k;
                for (std::size_t node = 0; node < Nodes; ++node) {
                    values[k].x[Nodes * p + node] = sample[2 * node];
                    values[k].y[Nodes * p + node] = sample[2 * node + 1];
                }
            }
        transform.forward(values, room);
        for (std::size_t b = 0; b < count; ++b) {
            const complex_block& block = values[band_.bins[b]];
            for (std::size_t p = 0; p < pairs; ++p)
                for (std::size_t node = 0; node < Nodes; ++node)
                    to[p * count + b] +=
                        weights[Nodes * b + node] * vec2{block.x[Nodes * p + node], block.y[Nodes * p + node]};
        }
    }

    template <class Policy>
    void add_noise(const Policy& policy, channel_data& out) const {
        if (!(settings_.noise_level_db > no_level_db)) return;
        const float level = amplitude_of_decibels(settings_.noise_level_db);
        const std::uint64_t seed = hash_bits(settings_.noise_seed, settings_.frame);
        exec::for_each_block(policy, std::size_t{out.transmits} * elements_, 16, 5 * static_cast<float>(out.samples),
                             [&](std::size_t begin, std::size_t end) {
                                 for (std::size_t k = begin * out.samples; k < end * out.samples; ++k)
                                     out.values[k] += level * hash_normal(seed, k).x;
                             });
    }

    const scene& body_;
    pose at_;
    const Model& model_;
    const channel_settings& settings_;
    std::uint32_t threads_;
    float frequency_ = 0, width_ = 0, height_ = 0, speed_ = display_speed;
    std::uint32_t elements_ = 0;
    pair_numbers pairs_{};
    record_plan record_{};
    band band_{};
    element_fans fans_{};
    elevation_field field_{};
    std::vector<reflector> reflectors_{};
    std::vector<zone> zones_{};
};

/// @throws usage_error  for elements that do not look into the slice, or are not in order
template <class Deferred = void>
void check_places(view<const ray> places) {
    for (std::size_t i = 0; i < places.size(); ++i) {
        const ray& one = places[i];
        const std::string name = "trace_channels: element " + std::to_string(i);
        if (!is_finite(one.origin) || !is_finite(one.direction))
            throw usage_error{name, " is not finite; check its centre and its normal"};
        if (std::fabs(one.direction.y) > 1e-5F || std::fabs(length(one.direction) - 1) > 1e-4F)
            throw usage_error{name, ": its normal must have length 1 and lie in the plane y = 0"};
        if (!(one.direction.z > 0))
            throw usage_error{name, " looks back; z of its normal must be above 0: round arrays have no channel data"};
        constexpr float rounding = 1e-7F; // metres
        if (i > 0 && one.origin.x < places[i - 1].origin.x - rounding)
            throw usage_error{name, " lies left of the one before; elements must be in order of x, a matrix array "
                                    "column after column"};
    }
}

} // namespace detail

/// What each element receives of each transmit.
///
///     const element_array array = presets::l11_5v_elements;
///     const channel_data received =
///         trace_channels(exec::par_unseq, body, array, at, physical{}, plane_waves(array, 11, 20_deg), {.depth =
/// 40_mm});
///
/// Surfaces reflect by Kirchhoff's integral, tissue scatters as in pictures; travel times are those of Fermat's
/// principle, attenuation follows frequency. What is missing: echoes that are reflected more than once.
/// @param array  see `element_transducer`
/// @param at     array to world: x lateral, y elevation, z depth
/// @param model  `physical`, with laws of its own or yours
/// @param sent   the transmits
/// @throws usage_error     for a scene that was not built, settings or transmits out of range, an element inside of
///                         what blocks sound, or more memory than `max_memory`
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, element_transducer Array, detail::reflects_everything Model>
channel_data trace_channels(const Policy& policy, const scene& body, const Array& array, const pose& at,
                            const Model& model, std::span<const transmit> sent, const channel_settings& settings = {}) {
    array.check();
    if constexpr (requires { model.check(); }) model.check();
    detail::check_lines(body, array.frequency, at, settings.depth, "trace_channels");
    if (!is_finite(settings.opening) || !(settings.opening >= 0 && settings.opening <= 80 * pi / 180))
        throw usage_error{"trace_channels: `opening` must be 0 to 80 degrees: write 30_deg"};
    if (!detail::is_number(settings.noise_level_db) || settings.noise_level_db > 100)
        throw usage_error{
            "trace_channels: `noise_level_db` must be at most 100 dB, such as -60; by default there is none"};
    if (sent.empty())
        throw usage_error{"trace_channels: there are no transmits; make some, as with plane_waves(array, 11, 20_deg)"};
    for (std::size_t i = 0; i < sent.size(); ++i) detail::check_transmit(sent[i], i, array.elements);
    if (settings.depth * array.frequency > detail::max_wavelengths * display_speed / 256)
        throw usage_error{"trace_channels: `depth` is more than 65536 wavelengths; lower it or the frequency"};
    channel_data out;
    out.transmits = static_cast<std::uint32_t>(sent.size());
    out.elements = array.elements;
    out.frequency = array.frequency;
    out.bandwidth = array.bandwidth;
    out.sound_speed = array.sound_speed;
    out.element_width = array.element_width;
    out.height = array.height;
    out.elevation_focus = array.elevation_focus;
    for (std::uint32_t i = 0; i < array.elements; ++i) out.places.push_back(array.element(i));
    detail::check_places(out.places);
    for (std::uint32_t i = 1; i < array.elements; ++i)
        out.pitch += length(out.places[i].origin - out.places[i - 1].origin) / static_cast<float>(array.elements - 1);
    if (array.elements == 1) out.pitch = array.element_width;
    out.sent.assign(sent.begin(), sent.end());
    using exec::max_threads;
    detail::channel_tracer<Model>{body, at, model, settings, max_threads(policy)}.run(
        detail::any_policy<exec::is_unsequenced_v<Policy>>{policy}, array.fnumber, out);
    return out;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
