#ifndef INSONIFY_PYTHON_ANY_SCANNER_HPP
#define INSONIFY_PYTHON_ANY_SCANNER_HPP

#include "velocity_fields.hpp"
#include <variant>

namespace insonify_python {

/// How sound travels: a tracer of the library.
using any_tracer = std::variant<straight_lines, paths>;

/// A frame of a scanner's cine loop.
struct stored_picture {
    pose at{};
    double time = 0;
    scan_lines amplitudes{};
};

/// The scanner of Python, which has one type for all probes. Pictures are copies: the next frame overwrites those of the
/// library, and may move their memory.
class any_scanner {
  public:
    any_scanner() = default;
    any_scanner(const any_scanner&) = delete;
    any_scanner& operator=(const any_scanner&) = delete;
    virtual ~any_scanner() = default;

    virtual py::object probe(const py::object& self) = 0; ///< a reference to it
    virtual void set_probe(const py::object& probe) = 0;
    virtual b_mode_settings& settings() = 0;
    virtual physical<>& model() = 0;
    virtual py::object how(const py::object& self) = 0; ///< a reference to it
    virtual void set_how(const py::object& how) = 0;
    virtual double& time() = 0;
    virtual std::uint32_t& cine_length() = 0;

    virtual image scan(const std::string& policy, const scene& body, const pose& at) = 0;
    virtual image show(const std::string& policy, std::uint32_t back) = 0;
    virtual label_image labels(const std::string& policy, const scene& body) = 0;
    virtual flow_lines colour(const std::string& policy, const scene& body, const velocity_fields& field,
                              const doppler_settings& settings) = 0;
    virtual doppler_spectrum spectrum(const std::string& policy, const scene& body, const velocity_fields& field,
                                      const pulsed_doppler_settings& settings) = 0;
    virtual void freeze() = 0;
    virtual void unfreeze() = 0;
    virtual bool frozen() const = 0;
    virtual void forget() = 0;

    virtual std::uint32_t stored() const = 0;
    virtual stored_picture stored(std::uint32_t back) const = 0; ///< not checked
    virtual const image& picture() const = 0;
    virtual const scan_lines& lines() const = 0;
    virtual const iq_lines& echoes() const = 0;
    virtual std::vector<ray> echo_beams() const = 0; ///< the lines of the echoes, in the frame of the probe
    virtual const line_layers& layers() const = 0;
    virtual const scan_map& map() const = 0;
    virtual const pose& at() const = 0;
    virtual const stage_times& times() const = 0;
    virtual vec3 point(vec2 pixel) const = 0;
    virtual vec2 pixel(vec3 point) const = 0;
};

/// Doppler of a scanner, compiled in the files of Doppler.
template <class Probe, class Tracer>
struct scanner_doppler {
    using machine = scanner<Probe, physical<>, Tracer>;
    static flow_lines colour(machine& own, const std::string& policy, const scene& body, const velocity_fields& field,
                             const doppler_settings& settings);
    static doppler_spectrum spectrum(machine& own, const std::string& policy, const scene& body,
                                     const velocity_fields& field, const pulsed_doppler_settings& settings);
};

/// The scanner of a type of probe and of tracer.
template <class Probe, class Tracer>
class scanner_of final : public any_scanner {
  public:
    scanner_of(const Probe& probe, const b_mode_settings& settings, const physical<>& model, const Tracer& how)
        : own_{probe, settings, model, how} {}

    py::object probe(const py::object& self) override {
        return py::cast(&own_.probe, py::return_value_policy::reference_internal, self);
    }
    void set_probe(const py::object& probe) override { assign(own_.probe, probe, "probe", "array"); }
    b_mode_settings& settings() override { return own_.settings; }
    physical<>& model() override { return own_.model; }
    py::object how(const py::object& self) override {
        return py::cast(&own_.how, py::return_value_policy::reference_internal, self);
    }
    void set_how(const py::object& how) override { assign(own_.how, how, "how", "tracer"); }
    double& time() override { return own_.time; }
    std::uint32_t& cine_length() override { return own_.cine_length; }

    image scan(const std::string& policy, const scene& body, const pose& at) override {
        return run(policy, [&](const auto& chosen) { return image{own_.scan(chosen, body, at)}; });
    }
    image show(const std::string& policy, std::uint32_t back) override {
        return run(policy, [&](const auto& chosen) { return image{own_.show(chosen, back)}; });
    }
    label_image labels(const std::string& policy, const scene& body) override {
        return run(policy, [&](const auto& chosen) { return label_image{own_.labels(chosen, body)}; });
    }
    flow_lines colour(const std::string& policy, const scene& body, const velocity_fields& field,
                      const doppler_settings& settings) override {
        return scanner_doppler<Probe, Tracer>::colour(own_, policy, body, field, settings);
    }
    doppler_spectrum spectrum(const std::string& policy, const scene& body, const velocity_fields& field,
                              const pulsed_doppler_settings& settings) override {
        return scanner_doppler<Probe, Tracer>::spectrum(own_, policy, body, field, settings);
    }
    void freeze() override { own_.freeze(); }
    void unfreeze() override { own_.unfreeze(); }
    bool frozen() const override { return own_.frozen(); }
    void forget() override { own_.forget(); }

    std::uint32_t stored() const override { return own_.cine().size(); }
    stored_picture stored(std::uint32_t back) const override {
        const auto& frame = own_.cine()[back];
        return {frame.at, frame.time, frame.amplitudes};
    }
    const image& picture() const override { return own_.picture(); }
    const scan_lines& lines() const override { return own_.lines(); }
    const iq_lines& echoes() const override { return own_.echoes(); }
    std::vector<ray> echo_beams() const override {
        std::vector<ray> beams;
        for (std::uint32_t line = 0; line < own_.echo_probe().lines; ++line)
            beams.push_back(own_.echo_probe().beam(static_cast<float>(line)));
        return beams;
    }
    const line_layers& layers() const override { return own_.layers(); }
    const scan_map& map() const override { return own_.map(); }
    const pose& at() const override { return own_.at(); }
    const stage_times& times() const override { return own_.times(); }
    vec3 point(vec2 pixel) const override { return own_.point(pixel); }
    vec2 pixel(vec3 point) const override { return own_.pixel(point); }

  private:
    /// @param kind  for the message, such as "array"
    /// @throws py::type_error  for a value of another type
    template <class Type>
    static void assign(Type& member, const py::object& given, const std::string& name, const std::string& kind) {
        if (!py::isinstance<Type>(given))
            throw py::type_error("scanner: `" + name + "` stays of the type " +
                                 py::cast<std::string>(py::type::of<Type>().attr("__name__")) +
                                 "; make another scanner for another " + kind);
        member = py::cast<const Type&>(given);
    }

    scanner<Probe, physical<>, Tracer> own_;
};

} // namespace insonify_python
#endif
