#include <insonify/core/units.hpp>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("units: integer and floating-point literals yield SI values") {
    static_assert(40_mm == 0.04F && 2.5_mm == 0.0025F && 3_cm == 0.03F && 2_m == 2.0F && 1_um == 1e-6F);
    static_assert(5_MHz == 5e6F && 7.5_MHz == 7.5e6F && 2_kHz == 2000.0F && 3_Hz == 3.0F);
    static_assert(0.54_dB_per_cm == 54.0F && 12_dB_per_m == 12.0F && 1.7_MRayl == 1.7e6F);
    static_assert(180_deg == 3.14159265358979F && 2_rad == 2.0F && 13_us == 13e-6F && 4_ms == 4e-3F && 1_s == 1.0F);
    static_assert(1540_m_per_s == 1540.0F && 998_kg_per_m3 == 998.0F && 415_Rayl == 415.0F);
    static_assert(760_mmHg > 101324.9F && 760_mmHg < 101325.1F); // 1 atm = 101325 Pa
    CHECK(-10_mm == -0.01F);
}
