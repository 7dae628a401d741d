// Asks a running hggmap for a place in words and leads the robot there:
//   go_to "the bench next to the tree" ["udpm://239.255.76.67:7667?ttl=0"]
// Prints the answer, then publishes the next point of the path as NAV_TARGET (bot_core.pose_t) until the robot is there.
// Exit codes: 0 there, 1 no such thing or no way, 2 no answer, or bad usage.
#include <bot_core/pose_t.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <hgg/goal_query_t.hpp>
#include <hgg/goal_reply_t.hpp>
#include <hgg/graph_update_t.hpp>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <string>

using Clock = std::chrono::steady_clock;
constexpr double kAhead = 0.8, kThere = 0.3;  // m: how far ahead the robot is led, how near is near enough
constexpr std::chrono::seconds kAskAgain(1), kPatience(15);

struct Client {
  std::map<std::int64_t, std::string> things;  // the graph: names by id
  hgg::goal_query_t query{};
  hgg::goal_reply_t reply{};
  bot_core::pose_t robot{};
  std::string why = "does hggmap run?";  // there is no answer
  bool is_answered = false, has_pose = false;

  void onGraph(const lcm::ReceiveBuffer*, const std::string&, const hgg::graph_update_t* update) {
    for (const auto& object : update->objects) things[object.id] = object.name;
    for (const auto id : update->removed) things.erase(id);
  }
  void onPose(const lcm::ReceiveBuffer*, const std::string&, const bot_core::pose_t* pose) {
    robot = *pose, has_pose = true;
  }
  void onReply(const lcm::ReceiveBuffer*, const std::string&, const hgg::goal_reply_t* r) {
    const bool is_ours = r->client == query.client && r->request_id == query.request_id;
    if (is_ours && r->status == hgg::goal_reply_t::FAILED) why = r->text;  // ask again
    if (is_ours && r->status != hgg::goal_reply_t::FAILED) reply = *r, is_answered = true;
  }
  double distanceTo(int k) const { return std::hypot(reply.path_x[k] - robot.pos[0], reply.path_y[k] - robot.pos[1]); }
  int nextWaypoint() const {  // the first one kAhead beyond that nearest to the robot
    int next = 0;
    for (int k = 0; k < reply.num_waypoints; ++k) next = distanceTo(k) < distanceTo(next) ? k : next;
    while (next + 1 < reply.num_waypoints && distanceTo(next) < kAhead) ++next;
    return next;
  }
};

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: go_to \"TEXT\" [LCM_URL]\n"), 2;
  lcm::LCM lcm(argc > 2 ? argv[2] : "");
  Client client;
  if (!lcm.good()) return std::fprintf(stderr, "cannot open LCM\n"), 2;
  lcm.subscribe("MAP_OBJECTS", &Client::onGraph, &client);
  lcm.subscribe("POSE_MAP", &Client::onPose, &client);
  lcm.subscribe("GOAL_REPLY", &Client::onReply, &client);

  const auto start = Clock::now();
  client.query.utime = std::chrono::system_clock::now().time_since_epoch() / std::chrono::microseconds(1);
  client.query.client = "go_to", client.query.request_id = client.query.utime;
  client.query.text = argv[1], client.query.with_goal = true;
  for (auto ask = start; !client.is_answered; lcm.handleTimeout(50)) {  // the bus may lose messages: ask until answered
    if (Clock::now() > start + kPatience) return std::fprintf(stderr, "no answer: %s\n", client.why.c_str()), 2;
    if (Clock::now() >= ask) lcm.publish("GOAL_QUERY", &client.query), ask += kAskAgain;
  }
  const hgg::goal_reply_t& reply = client.reply;
  std::printf("answered after %.0f ms\n", std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  for (const auto& a : reply.answers) std::printf("%3.0f %%  %s\n", 100 * a.probability, a.reason.c_str());
  std::printf("%s %s\n", reply.text.c_str(), reply.goal_reason.c_str());
  if (reply.num_waypoints == 0) return 1;
  std::printf("goal %.3f %.3f %.3f, yaw %.3f rad, %.1f m to walk, for object %lld\n", reply.goal[0], reply.goal[1],
              reply.goal[2], reply.goal[3], reply.path_length, static_cast<long long>(reply.answers[0].id));
  std::fflush(stdout);
  while (!client.has_pose || client.distanceTo(reply.num_waypoints - 1) > kThere) {
    if (lcm.handleTimeout(100) <= 0 || !client.has_pose) continue;
    const int next = client.nextWaypoint();
    bot_core::pose_t target = client.robot;
    target.pos[0] = reply.path_x[next], target.pos[1] = reply.path_y[next], target.pos[2] = reply.path_z[next];
    lcm.publish("NAV_TARGET", &target);
  }
  std::printf("there; the map has %zu things\n", client.things.size());
  return 0;
}
