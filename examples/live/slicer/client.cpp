/// Measures a server of OpenIGTLink as a client sees it: slicer_client --help
///
/// Sends ProbeToReference, and takes the time until an IMAGE that was acquired there has arrived. Checks the pitch and the
/// position of that image: corners of the nerve block's picture, 38 x 40 mm, in the world. Written with the library of
/// OpenIGTLink, as clients are, and without insonify.
#include "../../command_line.hpp"
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <igtlClientSocket.h>
#include <igtlImageMessage.h>
#include <igtlTransformMessage.h>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

using clock_type = std::chrono::steady_clock;

constexpr double width = 38, depth = 40;    // mm, of the picture
constexpr double first_x = -8, step = 0.02; // mm, of the poses
constexpr double tilt = 0.1, turn = 0.3;    // radians, of all poses

// Column by column: x across the picture, y out of it, z down. Turned about z, then tilted about its x axis.
void probe_pose(std::size_t number, igtl::Matrix4x4& pose) {
    const double x[3] = {std::cos(turn), std::sin(turn), 0};
    const double z[3] = {std::sin(turn) * std::sin(tilt), -std::cos(turn) * std::sin(tilt), std::cos(tilt)};
    const double y[3] = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
    const double origin[3] = {first_x + step * static_cast<double>(number), 2, 0};
    for (int row = 0; row < 3; ++row) {
        pose[row][0] = static_cast<float>(x[row]);
        pose[row][1] = static_cast<float>(y[row]);
        pose[row][2] = static_cast<float>(z[row]);
        pose[row][3] = static_cast<float>(origin[row]);
        pose[3][row] = 0;
    }
    pose[3][3] = 1;
}

// Where a point of the picture is in the world: mm from the middle of the probe's face to the right, and down.
void expected_point(std::size_t number, double right, double down, double* world) {
    igtl::Matrix4x4 pose;
    probe_pose(number, pose);
    for (int row = 0; row < 3; ++row) world[row] = pose[row][0] * right + pose[row][2] * down + pose[row][3];
}

// Where a pixel is by the message: OpenIGTLink gives the position of the middle of the image.
void stated_point(igtl::ImageMessage& image, double column, double row, double* world) {
    igtl::Matrix4x4 axes;
    float spacing[3];
    int size[3];
    image.GetMatrix(axes);
    image.GetSpacing(spacing);
    image.GetDimensions(size);
    const double i = spacing[0] * (column - 0.5 * (size[0] - 1)), j = spacing[1] * (row - 0.5 * (size[1] - 1));
    for (int k = 0; k < 3; ++k) world[k] = axes[k][0] * i + axes[k][1] * j + axes[k][3];
}

// Largest distance of the four corners from where they belong, mm.
double corner_error(igtl::ImageMessage& image, std::size_t number) {
    int size[3];
    image.GetDimensions(size);
    double largest = 0;
    for (const double right : {0.0, 1.0})
        for (const double down : {0.0, 1.0}) {
            double is[3], belongs[3]; // the edge is half a pixel outside the middle of the last one
            stated_point(image, right * size[0] - 0.5, down * size[1] - 0.5, is);
            expected_point(number, (right - 0.5) * width, down * depth, belongs);
            largest = std::max(largest, std::hypot(is[0] - belongs[0], is[1] - belongs[1], is[2] - belongs[2]));
        }
    return largest;
}

struct measured {
    std::vector<double> latencies{}; // ms
    double corner_error = 0;         // mm, largest
    std::vector<unsigned char> first{}, last{};
    int images = 0;
    double seconds = 0;
};

measured measure(int port, std::size_t count) {
    const igtl::ClientSocket::Pointer socket = igtl::ClientSocket::New();
    if (socket->ConnectToServer("localhost", port) != 0) throw std::runtime_error{"nobody listens on that port"};
    socket->SetReceiveTimeout(5000);
    std::vector<std::atomic<clock_type::duration::rep>> sent(count);
    // A pose each 47 ms, which is no multiple of the time between two pictures.
    std::thread sender{[&] {
        for (std::size_t number = 0; number < count; ++number) {
            const igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
            igtl::Matrix4x4 pose;
            probe_pose(number, pose);
            message->SetDeviceName("ProbeToReference");
            message->SetMatrix(pose);
            message->Pack();
            sent[number] = clock_type::now().time_since_epoch().count();
            socket->Send(message->GetPackPointer(), message->GetPackSize());
            std::this_thread::sleep_for(std::chrono::milliseconds{47});
        }
    }};
    measured result;
    const clock_type::time_point begin = clock_type::now();
    std::vector<bool> seen(count, false);
    try {
        while (!seen.back()) {
            const igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
            header->InitPack();
            if (socket->Receive(header->GetPackPointer(), header->GetPackSize()) != header->GetPackSize())
                throw std::runtime_error{"the server has sent nothing for 5 s"};
            header->Unpack();
            if (std::string{header->GetDeviceType()} != "IMAGE") {
                socket->Skip(header->GetBodySizeToRead(), 1);
                continue;
            }
            const igtl::ImageMessage::Pointer image = igtl::ImageMessage::New();
            image->SetMessageHeader(header);
            image->AllocatePack();
            socket->Receive(image->GetPackBodyPointer(), image->GetPackBodySize());
            const clock_type::time_point arrived = clock_type::now();
            if ((image->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) == 0)
                throw std::runtime_error{"the checksum is wrong"};
            ++result.images;
            // The number of the pose follows from the middle of the upper edge.
            double edge[3], first_edge[3];
            int size[3];
            image->GetDimensions(size);
            stated_point(*image, 0.5 * (size[0] - 1), -0.5, edge);
            expected_point(0, 0, 0, first_edge);
            const double number = (edge[0] - first_edge[0]) / step;
            if (std::fabs(edge[1] - first_edge[1]) > 0.1 || number < -0.4 || number > static_cast<double>(count) - 0.6)
                continue;
            const auto pose = static_cast<std::size_t>(std::lround(number));
            if (seen[pose]) continue;
            seen[pose] = true;
            result.latencies.push_back(std::chrono::duration<double, std::milli>(
                                           arrived.time_since_epoch() - clock_type::duration{sent[pose].load()})
                                           .count());
            result.corner_error = std::max(result.corner_error, corner_error(*image, pose));
            const auto* const pixels = static_cast<unsigned char*>(image->GetScalarPointer());
            result.last.assign(pixels, pixels + image->GetImageSize());
            if (result.first.empty()) result.first = result.last;
        }
    } catch (...) {
        sender.join();
        throw;
    }
    result.seconds = std::chrono::duration<double>(clock_type::now() - begin).count();
    sender.join();
    socket->CloseSocket();
    return result;
}

int run(int port, std::size_t count) {
    measured result = measure(port, count);
    std::sort(result.latencies.begin(), result.latencies.end());
    const auto quantile = [&](double fraction) {
        return result.latencies[static_cast<std::size_t>(fraction * static_cast<double>(result.latencies.size() - 1))];
    };
    double difference = 0;
    for (std::size_t i = 0; i < std::min(result.first.size(), result.last.size()); ++i)
        difference += std::abs(result.first[i] - result.last[i]);
    difference /= static_cast<double>(result.last.size());
    std::printf("transform sent to image received: median %.1f ms, 99th percentile %.1f ms (%zu of %zu poses)\n",
                quantile(0.5), quantile(0.99), result.latencies.size(), count);
    std::printf("%.1f images a second\n", result.images / result.seconds);
    std::printf("corners of the image in the world: within %.4f mm, expected 0.1\n", result.corner_error);
    std::printf("first and last image differ by %.1f gray values, expected more than 2\n", difference);
    return result.corner_error < 0.1 && difference > 2 && result.latencies.size() >= 10 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    int port = 18944;
    std::size_t transforms = 100;
    return command_line::run(
        "slicer_client", argc, argv,
        [&](CLI::App& app) {
            using namespace command_line;
            app.description("Measures a server of OpenIGTLink as a client sees it.");
            add_whole_number(app, "--port", port, "NUMBER", "TCP port of the server on this machine", 1, 65535);
            add_whole_number(app, "--transforms", transforms, "COUNT", "poses that are sent", 20, 100'000);
        },
        [&] { return run(port, transforms); });
}
