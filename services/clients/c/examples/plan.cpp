// Plans scenes with the running planner: plan SCENE.json [DOMAIN]. Prints the reply as JSON if
// CLEARWAY_JSON is set, else a line for each sample: seconds, metres, radians.
#include <clearway.hpp>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

int main(int count, char** arguments) {
    if (count < 2) {
        std::fprintf(stderr, "usage: plan SCENE.json [DOMAIN]\n");
        return 2;
    }
    std::ifstream file(arguments[1]);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto scene = clearway::scene::read(text);
    if (!scene) {
        std::fprintf(stderr, "%s: %s\n", arguments[1], scene.error().message());
        return EXIT_FAILURE;
    }
    const auto client = clearway::client::connect(count > 2 ? arguments[2] : nullptr);
    if (!client) {
        std::fprintf(stderr, "planner: %s\n", client.error().message());
        return EXIT_FAILURE;
    }
    const auto reply = client->plan(*scene, 10.0);
    if (!reply) {
        std::fprintf(stderr, "%s: %s\n", arguments[1], reply.error().message());
        return EXIT_FAILURE;
    }
    if (std::getenv("CLEARWAY_JSON") != nullptr) {
        std::puts(reply->json().c_str());
        return EXIT_SUCCESS;
    }
    for (std::size_t answer = 0; answer < reply->answers(); ++answer) {
        const auto trajectory = reply->trajectory(answer);
        if (!trajectory) {
            std::fprintf(stderr, "answer: %s\n", trajectory.error().message());
            return EXIT_FAILURE;
        }
        const clearway::summary said = trajectory->summary();
        std::fprintf(stderr, "%.3f m in %.3f s, %.3f m from the walls\n", said.length,
                     said.duration, said.clearance);
        trajectory->for_each_sample([](const clearway::sample& found) {
            std::printf("%.3f %.4f %.4f %.4f %.4f\n", found.t, found.position[0],
                        found.position[1], found.position[2], found.heading);
        });
    }
}
