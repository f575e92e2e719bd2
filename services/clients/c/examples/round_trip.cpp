// Times round trips with the running planner: round_trip SCENE.json DOMAIN CALLS. Prints the
// median and the 99th percentile, microseconds; see services/clients/round_trip.sh.
#include <clearway.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

int main(int count, char** arguments) {
    if (count != 4) return 2;
    std::ifstream file(arguments[1]);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    auto scene = clearway::scene::read(text).value();
    auto client = clearway::client::connect(arguments[2]).value();
    const std::size_t calls = std::stoul(arguments[3]);
    std::vector<double> times;
    times.reserve(calls);
    volatile double seen = 0.0;
    for (std::size_t call = 0; call < calls; ++call) {
        const auto begin = std::chrono::steady_clock::now();
        {
            auto reply = client.plan(scene, 10.0).value();
            for (std::size_t answer = 0; answer < reply.answers(); ++answer) {
                auto trajectory = reply.trajectory(answer).value();
                for (std::size_t block = 0; block < trajectory.blocks(); ++block)
                    seen = trajectory.block(block)[0].t;
            }
        }
        const std::chrono::duration<double, std::micro> took =
            std::chrono::steady_clock::now() - begin;
        times.push_back(took.count());
    }
    std::sort(times.begin(), times.end());
    std::printf("%.1f %.1f\n", times[calls / 2], times[calls * 99 / 100]);
    (void)seen;
}
