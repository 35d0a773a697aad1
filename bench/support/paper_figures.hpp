#ifndef INSONIFY_BENCH_PAPER_FIGURES_HPP
#define INSONIFY_BENCH_PAPER_FIGURES_HPP

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

/// The tables and figures of the paper's performance tests.
namespace bench::paper {

/// One test: a curve for each algorithm, a row for each size.
struct test {
    std::string name{}, across{};
    std::vector<std::string> curves{};
    std::vector<std::pair<double, std::vector<double>>> rows{}; // size, milliseconds of each curve

    void add(double size, const std::vector<double>& milliseconds) {
        if (rows.empty()) {
            std::printf("\n%s, ms a frame\n\n| %s |", name.c_str(), across.c_str());
            for (const std::string& curve : curves) std::printf(" %s |", curve.c_str());
            std::printf("\n|---|");
            for (std::size_t i = 0; i < curves.size(); ++i) std::printf("---|");
            std::puts("");
        }
        std::printf("| %.0f |", size);
        for (const double value : milliseconds) std::printf(" %.3g |", value);
        std::puts("");
        std::fflush(stdout);
        rows.push_back({size, milliseconds});
    }

    void write(const std::string& path) const {
        std::ofstream file{path};
        file << "# " << name << ", ms\n\"" << across << '"';
        for (const std::string& curve : curves) file << " \"" << curve << '"';
        for (const auto& [size, values] : rows) {
            file << '\n' << size;
            for (const double value : values) file << ' ' << value;
        }
        file << '\n';
    }
};

/// The paper's figures 4 to 6, where gnuplot is installed.
inline void draw(const std::string& folder) {
    const std::string script = folder + "/figures.gp";
    std::ofstream file{script};
    const auto curves = [&](const std::string& data, std::initializer_list<const char*> names, int first = 2) {
        std::string all;
        for (const char* name : names)
            all += (all.empty() ? "" : ", ") + ("'" + folder + "/" + data + ".dat' skip 2 using 1:" +
                                                std::to_string(first++) + " with linespoints title '" + name + "'");
        return all;
    };
    file
        << "set terminal pngcairo size 900,1100\nset output '" << folder << "/figure_4.png'\n"
        << "set key outside below\nset grid\nset logscale xy\nset xlabel 'triangles'\nset ylabel 'ms'\n"
        << "set multiplot layout 2,1\nset title 'Test 1: a complete, b without intensities, c without secondary rays'\n"
        << "plot "
        << curves("test_1a",
                  {"a Embree hit by hit", "a Embree filter", "a Embree packets", "a pixels", "a beams", "a slice"})
        << ", " << curves("test_1b", {"b Embree", "b Embree packets", "b beams", "b slice"}) << ", "
        << curves("test_1c", {"c Embree", "c Embree packets", "c pixels"}) << '\n'
        << "set title 'Test 1d: every vertex moves in every frame'\nplot "
        << curves("test_1d", {"Embree, rebuilt", "Embree, refitted", "beams, refitted", "slice, no tree"})
        << "\nunset multiplot\nset terminal pngcairo size 900,600\nset output '" << folder << "/figure_5.png'\n"
        << "set title 'Test 2: no acceleration structure'\nplot "
        << curves("test_2", {"a pixels", "beams", "a slice", "b slice"}) << "\nset output '" << folder
        << "/figure_6.png'\nset title 'Tests 3 and 4: cubes behind one another, separate cubes'\nset xlabel 'cubes'\n"
        << "plot "
        << curves("test_3",
                  {"3 Embree hit by hit", "3 Embree filter", "3 Embree packets", "3 pixels", "3 beams", "3 slice"})
        << ", "
        << curves("test_4",
                  {"4 Embree hit by hit", "4 Embree filter", "4 Embree packets", "4 pixels", "4 beams", "4 slice"})
        << '\n';
    file.close();
    if (std::system("command -v gnuplot > /dev/null") != 0)
        std::printf("\ngnuplot is not installed; `gnuplot %s` draws the figures elsewhere\n", script.c_str());
    else if (std::system(("gnuplot '" + script + "'").c_str()) == 0)
        std::printf("\nfigures 4 to 6 are in %s\n", folder.c_str());
}

} // namespace bench::paper

#endif
