// A planner that dies and what owners do, as seen from C++: life PART DOMAIN SCENE.json ENDLESS.json. Says
// "asked" and "lost", and goes on at a line on stdin; see ../check.sh. Ends with 0 if all was as it must be.
#include <clearway.hpp>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

namespace {

void check(bool holds, const std::string& what) {
    if (holds) return;
    std::fprintf(stderr, "life: not so: %s\n", what.c_str());
    std::exit(EXIT_FAILURE);
}

clearway::scene read_scene(const char* path) {
    std::ifstream file(path);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    return clearway::scene::read(text).value();
}

std::size_t samples(const clearway::reply& reply) {
    std::size_t count = 0;
    reply.trajectory().value().for_each_sample([&](const clearway::sample&) { ++count; });
    return count;
}

void owners(clearway::client client, const clearway::scene& scene, const clearway::scene& endless) {
    // Replies outlive their client, and are owned by whoever they are moved to.
    std::vector<clearway::reply> replies;
    for (int call = 0; call < 20; ++call) replies.push_back(client.plan(scene, 60.0).value());
    auto other = std::move(client);
    const auto first = samples(replies.front());
    check(first > 0 && samples(other.plan(scene, 60.0).value()) == first, "a client can be moved");
    // What is dropped is cancelled, and its place is free again.
    for (int call = 0; call < 20; ++call) check(other.start(endless).has_value(), "it is sent");
    auto late = other.plan(endless, 0.05);
    check(!late && late.error().status() == CLEARWAY_STATUS_TIMED_OUT, "what takes too long ends");
    auto pending = other.start(scene).value();
    auto waited = pending.wait(60.0);
    check(waited && samples(*waited) == first, "a request is waited for");
    {
        const auto gone = std::move(other);
    }
    for (const auto& reply : replies) check(samples(reply) == first, "replies outlive their client");
    try {
        clearway::scene::read("{").value();
        check(false, "no scene is read from half of one");
    } catch (const clearway::exception& failed) {
        check(failed.status() == CLEARWAY_STATUS_REFUSED, failed.what());
    }
}

void killed(const clearway::client& client, const clearway::scene& scene, const clearway::scene& endless) {
    const auto kept = client.plan(scene, 60.0).value();
    const auto first = samples(kept);
    auto pending = client.start(endless).value();
    std::cout << "asked" << std::endl;
    const auto lost = pending.wait(60.0);
    check(!lost && lost.error().status() == CLEARWAY_STATUS_PLANNER_LOST, "a killed planner is told");
    check(samples(kept) == first, "its replies stay");
    const auto none = client.plan(scene, 60.0);
    check(!none && none.error().status() == CLEARWAY_STATUS_NO_PLANNER, "there is none");
    std::cout << "lost" << std::endl;
    std::cin.get();
    check(samples(client.plan(scene, 60.0).value()) == first, "the next call works");
}

}  // namespace

int main(int count, char** arguments) {
    check(count == 5, "four arguments");
    const std::string part = arguments[1];
    auto client = clearway::client::connect(arguments[2], 10.0).value();
    const auto scene = read_scene(arguments[3]);
    const auto endless = read_scene(arguments[4]);
    if (part == "owners") owners(std::move(client), scene, endless);
    else if (part == "killed") killed(client, scene, endless);
    else check(false, "a part that there is");
}
