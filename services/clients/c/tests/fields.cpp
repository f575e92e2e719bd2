// Every field of replies as C++ has it: fields SCENES.jsonl DOMAIN plans a scene on each line, and prints the
// reply in the form of `plan --format json`, from what clearway.hpp hands out; see ../check.sh.
#include <clearway.hpp>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

namespace {

// What is not there is not printed.
class object {
public:
    void add(const char* name, const std::string& json) {
        text_ += (text_.empty() ? "{\"" : ", \"") + std::string(name) + "\": " + json;
    }
    std::string json() const { return text_.empty() ? "{}" : text_ + "}"; }

private:
    std::string text_;
};

std::string number(double value) {
    if (std::isinf(value)) return "null";
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

std::string text(const char* said) {
    std::string json = "\"";
    for (; *said != 0; ++said) json += *said == '"' || *said == '\\' ? std::string{'\\', *said} : std::string{*said};
    return json + "\"";
}

template <typename Count, typename Entry>
std::string list(Count count, Entry entry) {
    std::string json = "[";
    for (Count index = 0; index < count; ++index) json += (index == 0 ? "" : ", ") + entry(index);
    return json + "]";
}

std::string point(const double (&coordinates)[3], std::uint32_t dimension) {
    return list(dimension, [&](std::uint32_t axis) { return number(coordinates[axis]); });
}

std::string exit_of(clearway_exit exit) {
    static const char* const names[] = {"", "+x", "-x", "+y", "-y", "+z", "-z"};
    return text(names[exit]);
}

std::string leg(const clearway::leg& leg, std::uint32_t dimension) {
    static const char* const rungs[] = {"", "taut", "radius", "aligned", "reverse", "lattice"};
    object json;
    switch (leg.kind) {
        case CLEARWAY_LEG_KIND_LINE:
            json.add("kind", "\"line\"");
            json.add("from", point(leg.point, dimension));
            json.add("to", point(leg.to, dimension));
            json.add("heading", number(leg.heading));
            if (leg.sweep != 0.0) json.add("turned", number(leg.sweep));
            break;
        case CLEARWAY_LEG_KIND_ARC:
            json.add("kind", "\"arc\"");
            json.add("center", point(leg.point, dimension));
            json.add("radius", number(leg.radius));
            json.add("start_angle", number(leg.start));
            json.add("sweep", number(leg.sweep));
            break;
        case CLEARWAY_LEG_KIND_TURN:
            json.add("kind", "\"turn\"");
            json.add("position", point(leg.point, dimension));
            json.add("from_heading", number(leg.start));
            json.add("to_heading", number(leg.heading));
            break;
        case CLEARWAY_LEG_KIND_CLOTHOID:
            json.add("kind", "\"clothoid\"");
            json.add("from", point(leg.point, dimension));
            json.add("to", point(leg.to, dimension));
            json.add("from_heading", number(leg.start));
            json.add("to_heading", number(leg.heading));
            json.add("start_curvature", number(leg.curvatures[0]));
            json.add("end_curvature", number(leg.curvatures[1]));
            break;
    }
    if (leg.reverse) json.add("reverse", "true");
    json.add("length", number(leg.length));
    json.add("clearance", number(leg.clearance));
    if (leg.table != 0)
        json.add("rule", "\"table " + std::to_string(leg.table) + ", rule " + std::to_string(leg.number) + "\"");
    if (leg.junction >= 0) json.add("junction", std::to_string(leg.junction));
    if (leg.rung != CLEARWAY_RUNG_NONE) json.add("rung", text(rungs[leg.rung]));
    return json.json();
}

std::string sample(const clearway::sample& sample, std::uint32_t dimension) {
    object json;
    json.add("t", number(sample.t));
    json.add("position", point(sample.position, dimension));
    json.add("heading", number(sample.heading));
    json.add("velocity", point(sample.velocity, dimension));
    json.add("yaw_rate", number(sample.yaw_rate));
    return json.json();
}

std::string exceeds(const clearway::exceeds& exceeds) {
    static const char* const limits[] = {"", "yaw_acceleration"};
    object json;
    json.add("limit", text(limits[exceeds.limit]));
    json.add("joints", std::to_string(exceeds.joints));
    json.add("jump", number(exceeds.jump));
    return json.json();
}

std::string gaps(const clearway::trajectory& trajectory) {
    const auto gaps = trajectory.gaps();
    const auto each = trajectory.gaps_per_junction();
    if (each <= 1) return list(gaps.size(), [&](std::size_t index) { return number(gaps[index]); });
    return list(gaps.size() / each, [&](std::size_t junction) {
        return list(each, [&](std::size_t axis) { return number(gaps[junction * each + axis]); });
    });
}

std::string trajectory(const clearway::trajectory& trajectory) {
    const clearway::summary said = trajectory.summary();
    const auto route = trajectory.route();
    object json, wall;
    json.add("gap", gaps(trajectory));
    json.add("route", list(route.size(), [&](std::size_t index) { return std::to_string(route[index]); }));
    if (trajectory.channels() != 0)
        json.add("channels", list(trajectory.channels(), [&](std::size_t index) {
            const clearway::box channel = trajectory.channel(index);
            object corners;
            corners.add("min", point(channel.min, said.dimension));
            corners.add("max", point(channel.max, said.dimension));
            return corners.json();
        }));
    if (said.exit != CLEARWAY_EXIT_NONE) json.add("exit", exit_of(said.exit));
    json.add("length", number(said.length));
    if (!std::isnan(said.bound)) json.add("bound", number(said.bound));
    if (!said.complete) json.add("complete", "false");
    json.add("duration", number(said.duration));
    wall.add("value", number(said.clearance));
    wall.add("at", number(said.clearance_at));
    wall.add("wall", point(said.clearance_wall, said.dimension));
    json.add("clearance", wall.json());
    if (!std::isnan(said.free_clearance)) json.add("free_clearance", number(said.free_clearance));
    json.add("legs", list(trajectory.legs(), [&](std::size_t index) {
        return leg(trajectory.leg(index), said.dimension);
    }));
    if (said.exceeds.limit != CLEARWAY_LIMIT_NONE) json.add("exceeds", exceeds(said.exceeds));
    if (said.stops >= 0) json.add("stops", std::to_string(said.stops));
    std::string samples;
    trajectory.for_each_sample([&](const clearway::sample& found) {
        samples += (samples.empty() ? "" : ", ") + sample(found, said.dimension);
    });
    json.add("samples", "[" + samples + "]");
    return json.json();
}

std::string refusal(const clearway_refusal& refusal) {
    static const char* const axes[] = {"\"x\"", "\"y\"", "\"z\""};
    object json;
    const auto add = [&](const char* name, double value) {
        if (!std::isnan(value)) json.add(name, number(value));
    };
    json.add("code", text(refusal.code));
    json.add("message", text(refusal.message));
    if (refusal.field != nullptr) json.add("field", text(refusal.field));
    if (refusal.junction >= 0) json.add("junction", std::to_string(refusal.junction));
    if (refusal.axis >= 0) json.add("axis", axes[refusal.axis]);
    add("needs", refusal.needs);
    add("has", refusal.has);
    add("least", refusal.least);
    add("most", refusal.most);
    add("heading", refusal.heading);
    if (refusal.setting != nullptr) json.add("setting", text(refusal.setting));
    return json.json();
}

// A refusal as an object; errors of other kinds end the program.
std::string refused(const clearway::error& error) {
    const auto found = error.refusal();
    if (!found) {
        std::fprintf(stderr, "fields: %s\n", error.message());
        std::exit(EXIT_FAILURE);
    }
    object json;
    json.add("error", refusal(*found));
    return json.json();
}

std::string reply(const clearway::client& client, const std::string& line) {
    const auto scene = clearway::scene::read(line);
    if (!scene) return refused(scene.error());
    const auto reply = client.plan(*scene, 60.0);
    if (!reply) return refused(reply.error());
    object json;
    if (const auto id = reply->id()) json.add("id", std::to_string(*id));
    json.add("trajectories", list(reply->answers(), [&](std::size_t answer) {
        const auto found = reply->trajectory(answer);
        return found ? trajectory(*found) : refused(found.error());
    }));
    return json.json();
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 3) {
        std::fprintf(stderr, "usage: fields SCENES.jsonl DOMAIN\n");
        return 2;
    }
    const auto client = clearway::client::connect(arguments[2], 10.0);
    if (!client) {
        std::fprintf(stderr, "fields: %s\n", client.error().message());
        return EXIT_FAILURE;
    }
    std::ifstream file(arguments[1]);
    for (std::string line; std::getline(file, line);) std::puts(reply(*client, line).c_str());
}
