#include "query/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "query/description.h"
#include "query/relations.h"
#include "query/views.h"

namespace hgg {
namespace {

/// Anchors less probable than this, next to the most probable one, change no answer.
constexpr double kLeastAnchor = 0.02;
/// Peers: those whose class fits nearly as well as the best one's, in nats.
constexpr double kPeerSlack = 1.2;
/// How much of what the scene says of the classes that a word may mean is left out: 0 none, 1 all.
constexpr double kWordOverScene = 0.85;
/// How sure people are to mean a front as it is taken here, and not another side.
constexpr double kOwnFront = 0.8;

/// Things that a phrase may mean, with log-probabilities that need not add up.
struct Field {
  std::vector<int> things;  // indices in the scene, ascending
  std::vector<double> log_p;
};

double logSumExp(const std::vector<double>& values) {
  const double most = values.empty() ? 0 : std::ranges::max(values);
  double sum = 0;
  for (const double v : values) {
    sum += std::exp(v - most);
  }
  return values.empty() ? -std::numeric_limits<double>::infinity() : most + std::log(sum);
}

std::vector<Referent> normalised(const Field& field) {
  const double all = logSumExp(field.log_p);
  std::vector<Referent> candidates;
  for (std::size_t k = 0; k < field.things.size(); ++k) {
    candidates.push_back({field.things[k], std::exp(field.log_p[k] - all)});
  }
  std::ranges::stable_sort(candidates, std::ranges::greater{}, &Referent::probability);
  return candidates;
}

class Grounder {
 public:
  Grounder(const Request& request, const QueryScene& scene, const std::optional<Standpoint>& from)
      : request_(request),
        scene_(scene),
        from_(from),
        anchors_(request.phrases.size()),
        busy_(request.phrases.size()) {}

  Grounding ground() {
    const Field field = fieldOf(request_.target);
    Grounding grounding{normalised(field), anchors_, request_.log_prior + logSumExp(field.log_p)};
    return grounding;
  }

 private:
  const Phrase& phrase(int k) const { return request_.phrases[static_cast<std::size_t>(k)]; }
  const SceneThing& thing(int k) const { return scene_.things[static_cast<std::size_t>(k)]; }

  /// By what the things are, and that they are.
  Field byClass(const Phrase& p) const {
    std::map<int, double> share;
    for (const auto& [id, fit] : p.classes) {
      const auto of_class = scene_.of_class.find(id);
      for (const int k : of_class != scene_.of_class.end() ? of_class->second : std::vector<int>{}) {
        share[k] += fit * weightOf(thing(k).classes, id);
      }
    }
    for (std::size_t k = 0; p.is_any && k < scene_.things.size(); ++k) {
      if (!scene_.things[k].stuff) {
        share[static_cast<int>(k)] = 1;
      }
    }
    Field field;
    for (const auto& [k, s] : share) {
      if (s > 0) {
        field.things.push_back(k);
        field.log_p.push_back(std::log(s) + std::log(thing(k).existence));
      }
    }
    return field;
  }

  Peers peersOf(const Field& field) const {
    Peers peers{field.things, {}};
    const double most = field.log_p.empty() ? 0 : std::ranges::max(field.log_p);
    for (const double p : field.log_p) {
      peers.is_peer.push_back(p > most - kPeerSlack);
    }
    return peers;
  }

  /// First, last and largest are said among those that all else fits, and so come second.
  static bool comparesPeers(const Constraint& c) {
    const bool telling = c.relation == Relation::kClosest || c.relation == Relation::kFar;
    return c.kind == Constraint::Kind::kPlace || c.kind == Constraint::Kind::kMeasure ||
           (c.kind == Constraint::Kind::kRelation && telling);
  }

  Field fieldOf(int k) {
    const Phrase& p = phrase(k);
    Field field = byClass(p);
    busy_[static_cast<std::size_t>(k)] = true;
    const std::vector<double> by_class = field.log_p;
    for (const bool comparing : {false, true}) {
      const Peers peers = peersOf(field);
      std::vector<double> sum = field.log_p;
      for (const Constraint& said : p.constraints) {
        if (comparesPeers(said) == comparing) {
          addLogLikelihoods(said, field, peers, sum);
        }
      }
      field.log_p = std::move(sum);
    }
    settleClasses(by_class, field);
    busy_[static_cast<std::size_t>(k)] = false;
    return field;
  }

  void addLogLikelihoods(const Constraint& said, const Field& field, const Peers& peers, std::vector<double>& sum) {
    const std::vector<double> likelihoods = likelihoodsOf(said, field, peers);
    if (likelihoods.empty()) {
      return;
    }
    const double most = std::ranges::max(likelihoods);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double l = said.is_negated ? std::max(1 - 0.95 * likelihoods[i] / most, 0.02) : likelihoods[i];
      sum[i] += said.weight * std::log(std::max(l, 1e-9));
    }
  }

  /// Which class a word means is settled by the word more than by what is said of the thing: that no backpack is near
  /// makes the bag that is near a backpack only so far.
  void settleClasses(const std::vector<double>& by_class, Field& field) const {
    std::map<ClassId, std::vector<double>> said;
    for (std::size_t i = 0; i < by_class.size(); ++i) {
      said[thing(field.things[i]).label].push_back(field.log_p[i] - by_class[i]);
    }
    for (double& p : field.log_p) {
      p -= kWordOverScene *
           logSumExp(said[thing(field.things[static_cast<std::size_t>(&p - field.log_p.data())]).label]);
    }
  }

  const std::vector<Referent>& anchorsOf(int k) {
    std::vector<Referent>& found = anchors_[static_cast<std::size_t>(k)];
    if (found.empty() && !busy_[static_cast<std::size_t>(k)]) {
      found = normalised(fieldOf(k));
      const double least = found.empty() ? 0 : kLeastAnchor * found.front().probability;
      std::erase_if(found, [&](const Referent& c) { return c.probability < least; });
    }
    return found;
  }

  std::vector<double> likelihoodsOf(const Constraint& said, const Field& field, const Peers& peers) {
    switch (said.kind) {
      case Constraint::Kind::kPlace:
        return likelihoodOfPlace(scene_, peers, said, gazesFor(field.things));
      case Constraint::Kind::kMeasure:
        return likelihoodOfMeasure(scene_, peers, said);
      case Constraint::Kind::kColour:
        return likelihoodOfColour(scene_, peers, said);
      case Constraint::Kind::kShape:
        return {};
      case Constraint::Kind::kRelation:
        break;
    }
    if (said.anchors.empty()) {
      return {};
    }
    if (phrase(said.anchors.front()).is_robot) {
      return likelihoodsToRobot(said, field, peers);
    }
    if (said.relation == Relation::kBetween) {
      return likelihoodsBetween(said, field);
    }
    const std::vector<Referent>& anchors = anchorsOf(said.anchors.front());
    if (anchors.empty()) {
      return {};  // of something the map does not have
    }
    return said.relation == Relation::kFar ? likelihoodsFar(field, anchors, phrase(said.anchors.front()).is_other)
                                           : likelihoodsToAnchors(said, field, anchors);
  }

  std::vector<double> likelihoodsToAnchors(const Constraint& said, const Field& field,
                                           const std::vector<Referent>& anchors) {
    std::map<ClassId, std::pair<double, std::vector<double>>> of_class;  // the anchor's: its probability, and the sum
    for (const Referent& anchor : anchors) {
      auto& [probability, sum] = of_class[thing(anchor.thing).label];
      sum.resize(field.things.size());
      probability += anchor.probability;
      const std::vector<Gaze> gazes = gazesAtAnchor(said.relation, thing(anchor.thing), field.things);
      for (std::size_t i = 0; i < sum.size(); ++i) {
        if (field.things[i] != anchor.thing) {
          sum[i] +=
              anchor.probability * likelihoodOf(said.relation, thing(field.things[i]), thing(anchor.thing), gazes);
        }
      }
    }
    std::vector<double> all(field.things.size(), 0.0);
    for (const auto& [label, of] : of_class) {
      const double most = of.second.empty() ? 1 : std::max(std::ranges::max(of.second), 1e-12);
      for (std::size_t i = 0; i < all.size(); ++i) {
        all[i] += of.second[i] * of.first / most;
      }
    }
    return all;
  }

  static double likelihoodOf(Relation relation, const SceneThing& t, const SceneThing& anchor,
                             const std::vector<Gaze>& directions) {
    switch (relation) {
      case Relation::kClosest:
        return likelihoodClosest(t, anchor);
      case Relation::kOn:
        return likelihoodOn(t, anchor);
      case Relation::kSupporting:
        return likelihoodOn(anchor, t);
      case Relation::kAbove:
        return likelihoodAbove(t, anchor);
      case Relation::kBelow:
        return likelihoodBelow(t, anchor);
      case Relation::kInside:
        return likelihoodInside(t, anchor);
      case Relation::kWith:
        return likelihoodWith(t, anchor);
      case Relation::kFront:
      case Relation::kBehind:
      case Relation::kLeft:
      case Relation::kRight:
      case Relation::kAcross: {
        double sum = 0;
        for (const Gaze& d : directions) {
          sum += d.probability * (relation == Relation::kAcross ? likelihoodTowards(t, anchor, d.direction)
                                                                : likelihoodBeside(t, anchor, d.direction));
        }
        return sum;
      }
      default:
        return likelihoodNear(t, anchor);
    }
  }

  /// Far from all that the anchor may be: "the chair farthest from the doors".
  std::vector<double> likelihoodsFar(const Field& field, const std::vector<Referent>& anchors, bool) const {
    std::vector<double> log_sum(field.things.size(), 0.0);
    double all = 0;
    for (const Referent& anchor : anchors) {
      double farthest = 0;
      for (const int k : field.things) {
        farthest = std::max(farthest, nearDistance(thing(k), thing(anchor.thing)));
      }
      for (std::size_t i = 0; i < log_sum.size(); ++i) {
        log_sum[i] +=
            anchor.probability * std::log(likelihoodFar(thing(field.things[i]), thing(anchor.thing), farthest));
      }
      all += anchor.probability;
    }
    for (double& v : log_sum) {
      v = std::exp(v / std::max(all, 1e-9));
    }
    return log_sum;
  }

  std::vector<double> likelihoodsBetween(const Constraint& said, const Field& field) {
    const std::vector<Referent> a = anchorsOf(said.anchors.front());
    const bool is_pair = said.anchors.size() > 1;
    const std::vector<Referent> b = is_pair ? anchorsOf(said.anchors[1]) : a;
    const bool single = !is_pair && phrase(said.anchors.front()).count < 2 && a.size() < 2;
    if (a.empty() || b.empty() || single) {
      const std::vector<Referent>& known = a.empty() ? b : a;
      return known.empty() ? std::vector<double>{} : likelihoodsToAnchors(Constraint{}, field, known);
    }
    std::vector<double> sum(field.things.size(), 1e-6);
    constexpr std::size_t kMost = 12;  // anchors on each side: a hall of chairs has too many pairs
    for (std::size_t i = 0; i < std::min(a.size(), kMost); ++i) {
      for (std::size_t j = is_pair ? 0 : i + 1; j < std::min(b.size(), kMost); ++j) {
        if (a[i].thing == b[j].thing) {
          continue;
        }
        // Of many pairs, one that stands close is meant.
        const double close = 1 / (1 + gapBetween(thing(a[i].thing), thing(b[j].thing)));
        const double p = a[i].probability * b[j].probability * close;
        for (std::size_t k = 0; k < sum.size(); ++k) {
          if (field.things[k] != a[i].thing && field.things[k] != b[j].thing) {
            sum[k] += p * likelihoodBetween(thing(field.things[k]), thing(a[i].thing), thing(b[j].thing));
          }
        }
      }
    }
    return sum;
  }

  std::vector<double> likelihoodsToRobot(const Constraint& said, const Field& field, const Peers& peers) {
    if (!from_) {  // nobody stands anywhere: nearest to who looks is what is in front
      Constraint place;
      place.kind = Constraint::Kind::kPlace;
      place.place = said.relation == Relation::kFar ? Placement::kBack : Placement::kFront;
      return request_.view ? likelihoodOfPlace(scene_, peers, place, gazesFor(field.things)) : std::vector<double>{};
    }
    SceneThing robot;
    const Vec2 ahead(std::cos(from_->yaw), std::sin(from_->yaw));
    robot.centre = Vec3(from_->x, from_->y, scene_.low.z()), robot.half = Vec3(0.25, 0.25, 1), robot.front = ahead;
    std::vector<double> likelihoods;
    double farthest = 0;
    for (const int k : field.things) {
      farthest = std::max(farthest, nearDistance(thing(k), robot));
    }
    const Relation r = said.relation;
    const Vec2 side = r == Relation::kLeft     ? leftOf(ahead)
                      : r == Relation::kRight  ? Vec2(-leftOf(ahead))
                      : r == Relation::kBehind ? Vec2(-ahead)
                                               : ahead;
    for (const int k : field.things) {
      likelihoods.push_back(r == Relation::kFar ? likelihoodFar(thing(k), robot, farthest)
                                                : likelihoodOf(r, thing(k), robot, {{side, 1}}));
    }
    return likelihoods;
  }

  Vec2 meanOf(const std::vector<int>& things) const {
    Vec2 mean = Vec2::Zero();
    for (const int k : things) {
      mean += thing(k).centre.head<2>() / static_cast<double>(things.size());
    }
    return mean;
  }

  /// How one looks, by what the request says of it.
  std::vector<Gaze> gazesOfView(const std::vector<int>& things) {
    std::vector<Gaze> gazes;
    const View& view = *request_.view;
    const std::vector<Referent> anchors = view.phrase >= 0 ? anchorsOf(view.phrase) : doors();
    for (const Referent& c : anchors) {
      const Vec2 front = frontOf(scene_, thing(c.thing));
      const Vec2 apart = meanOf(things) - thing(c.thing).centre.head<2>();
      const bool is_far = apart.norm() > 0.5;
      if (view.kind == View::Kind::kFacing) {
        gazes.push_back({-front, c.probability});
      } else {
        gazes.push_back({front, c.probability * (is_far ? 0.4 : 1.0)});
        if (is_far) {
          gazes.push_back({apart.normalized(), c.probability * 0.6});
        }
      }
    }
    return gazes;
  }

  std::vector<Referent> doors() const {
    std::vector<Referent> found;
    for (std::size_t k = 0; k < scene_.things.size(); ++k) {
      const auto name = scene_.class_names.find(scene_.things[k].label);
      if (name != scene_.class_names.end() && name->second == "door") {
        found.push_back({static_cast<int>(k), 1});
      }
    }
    for (Referent& c : found) {
      c.probability /= static_cast<double>(found.size());
    }
    return found;
  }

  /// How one looks at things that are told apart among their like.
  std::vector<Gaze> gazesFor(const std::vector<int>& things) {
    if (request_.view) {
      if (std::vector<Gaze> gazes = gazesOfView(things); !gazes.empty()) {
        return gazes;
      }
    }
    if (from_) {
      const Vec2 towards = meanOf(things) - Vec2(from_->x, from_->y);
      return {
          {towards.norm() > 0.1 ? Vec2(towards.normalized()) : Vec2(std::cos(from_->yaw), std::sin(from_->yaw)), 1}};
    }
    return gazesAt(scene_, things);
  }

  /// The directions from an anchor in which a thing is left of it, in front of it and so on.
  std::vector<Gaze> gazesAtAnchor(Relation relation, const SceneThing& anchor, const std::vector<int>& things) {
    if (relation != Relation::kFront && relation != Relation::kBehind && relation != Relation::kLeft &&
        relation != Relation::kRight && relation != Relation::kAcross) {
      return {};
    }
    std::vector<Gaze> gazes;
    if (request_.view) {
      gazes = gazesOfView(things);
    } else if (from_) {
      const Vec2 towards = anchor.centre.head<2>() - Vec2(from_->x, from_->y);
      gazes = {
          {towards.norm() > 0.1 ? Vec2(towards.normalized()) : Vec2(std::cos(from_->yaw), std::sin(from_->yaw)), 1}};
    }
    if (gazes.empty()) {
      const Vec2 front = frontOf(scene_, anchor);
      gazes = {{-front, kOwnFront}, {front, 1 - kOwnFront}};
    }
    for (Gaze& g : gazes) {
      const Vec2 gaze = g.direction;
      g.direction = relation == Relation::kLeft     ? leftOf(gaze)
                    : relation == Relation::kRight  ? Vec2(-leftOf(gaze))
                    : relation == Relation::kBehind ? gaze
                                                    : Vec2(-gaze);
    }
    return gazes;
  }

  const Request& request_;
  const QueryScene& scene_;
  const std::optional<Standpoint>& from_;
  std::vector<std::vector<Referent>> anchors_;
  std::vector<bool> busy_;
};

}  // namespace

Grounding groundRequest(const Request& request, const QueryScene& scene, const std::optional<Standpoint>& from) {
  return Grounder(request, scene, from).ground();
}

Grounding groundReadings(const std::vector<Request>& readings, const QueryScene& scene,
                         const std::optional<Standpoint>& from, std::size_t& best) {
  std::vector<Grounding> groundings;
  std::vector<double> evidence;
  for (const Request& reading : readings) {
    groundings.push_back(groundRequest(reading, scene, from));
    evidence.push_back(groundings.back().log_evidence);
  }
  best = static_cast<std::size_t>(std::ranges::max_element(evidence) - evidence.begin());
  const double all = logSumExp(evidence);
  std::map<int, double> mixture;
  for (std::size_t k = 0; k < groundings.size(); ++k) {
    for (const Referent& c : groundings[k].target) {
      mixture[c.thing] += std::exp(evidence[k] - all) * c.probability;
    }
  }
  Grounding mixed = std::move(groundings[best]);
  mixed.target.clear();
  for (const auto& [k, p] : mixture) {
    mixed.target.push_back({k, p});
  }
  std::ranges::stable_sort(mixed.target, std::ranges::greater{}, &Referent::probability);
  mixed.log_evidence = all;
  return mixed;
}

}  // namespace hgg
