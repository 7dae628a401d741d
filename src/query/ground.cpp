#include "query/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "query/anchored.h"
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
/// People whose every word is understood mean what they say more exactly than the scales of the likelihoods, which hold
/// for all texts: the power that makes the answers to texts of the tuning scans most likely, Nr3D's as well as Sr3D's.
constexpr double kLiteral = 1.4;
/// That people say "on the right" of what is on the left.
constexpr double kWrongSide = 0.05;
const Vec3 kRobotHalf(0.25, 0.25, 1);  // m: half a robot

/// A class that a word may mean, and that a thing may be of.
struct Meaning {
  ClassId id = 0;
  double fit = 1, belief = 1;  // how readily the word is used for the class; P(class | thing)
};
using Meanings = std::vector<Meaning>;

/// Things that a phrase may mean, with log-probabilities that need not add up.
struct Field {
  std::vector<int> things;  // indices in the scene, ascending
  std::vector<double> log_p;
  std::vector<Meanings> meanings;
};

double logSumExp(const std::vector<double>& values) {
  const double most = values.empty() ? 0 : std::ranges::max(values);
  double sum = 0;
  for (const double v : values) {
    sum += std::exp(v - most);
  }
  return values.empty() ? -std::numeric_limits<double>::infinity() : most + std::log(sum);
}

Referents normalised(const Field& field) {
  const double all = logSumExp(field.log_p);
  Referents candidates;
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

  /// The things that a phrase may mean by its classes, by index.
  std::map<int, Meanings> meaningsOf(const Phrase& p) const {
    std::map<int, Meanings> meanings;
    for (const auto& [id, fit] : p.classes) {
      const auto of_class = scene_.of_class.find(id);
      for (const int k : of_class != scene_.of_class.end() ? of_class->second : std::vector<int>{}) {
        if (const double belief = weightOf(thing(k).classes, id); fit > 0 && belief > 0) {
          meanings[k].push_back({id, fit, belief});
        }
      }
    }
    for (std::size_t k = 0; p.is_any && k < scene_.things.size(); ++k) {
      if (!scene_.things[k].stuff) {
        meanings[static_cast<int>(k)] = {{scene_.things[k].label, 1, 1}};
      }
    }
    return meanings;
  }

  /// By what the things are, and that they are.
  Field byClass(const Phrase& p) const {
    Field field;
    for (auto& [k, meanings] : meaningsOf(p)) {
      double share = 0;
      for (const Meaning& m : meanings) {
        share += m.fit * m.belief;
      }
      field.things.push_back(k);
      field.log_p.push_back(std::log(share) + std::log(thing(k).existence));
      field.meanings.push_back(std::move(meanings));
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
    const double weight = said.weight * (request_.unread == 0 ? kLiteral : 1);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double l = said.is_negated ? std::max(1 - 0.95 * likelihoods[i] / most, 0.02) : likelihoods[i];
      sum[i] += weight * std::log(std::max({l, 1e-9 * most, 1e-300}));
    }
  }

  /// Which class a word means is settled by the word more than by what is said of the thing: that no backpack is near
  /// makes the bag that is near a backpack only so far. Where things are meant, a patch of stuff that touches
  /// everything around it gains nothing by that at all: "the tree next to the bin" is a trunk before it is a tile of
  /// vegetation. `by_class`: the log-probabilities before anything was said.
  void settleClasses(const std::vector<double>& by_class, Field& field) const {
    std::map<ClassId, std::vector<double>> said;  // of all that may be of the class
    for (std::size_t i = 0; i < field.things.size(); ++i) {
      for (const Meaning& m : field.meanings[i]) {
        said[m.id].push_back(std::log(m.belief) + field.log_p[i] - by_class[i]);
      }
    }
    std::map<ClassId, double> of_class;
    for (const auto& [id, values] : said) {
      of_class[id] = logSumExp(values);
    }
    const bool has_things = std::ranges::any_of(field.things, [&](int k) { return !thing(k).stuff; });
    for (std::size_t i = 0; i < field.things.size(); ++i) {
      const double left_out = thing(field.things[i]).stuff && has_things ? 1 : kWordOverScene;
      std::vector<double> before, settled;
      for (const Meaning& m : field.meanings[i]) {
        before.push_back(std::log(m.fit * m.belief));
        settled.push_back(before.back() - left_out * of_class.at(m.id));
      }
      field.log_p[i] += logSumExp(settled) - logSumExp(before);
    }
  }

  const Referents& anchorsOf(int k) {
    Referents& found = anchors_[static_cast<std::size_t>(k)];
    if (found.empty() && !busy_[static_cast<std::size_t>(k)]) {
      found = normalised(fieldOf(k));
      const double least = found.empty() ? 0 : kLeastAnchor * found.front().probability;
      std::erase_if(found, [&](const Referent& c) { return c.probability < least; });
    }
    return found;
  }

  std::vector<double> likelihoodsOf(const Constraint& said, const Field& field, const Peers& peers) {
    switch (said.kind) {
      case Constraint::Kind::kPlace: {
        Constraint place = said;
        if (said.is_bare) {  // from where one comes; without that, as one reads
          const bool comes = from_ || (request_.view && request_.view->kind == View::Kind::kEntering);
          place.place = comes ? Placement::kFront : Placement::kLeft;
        }
        return isBesideTheWay(place) ? likelihoodsBesideTheWay(place, peers)
                                     : likelihoodOfPlace(scene_, peers, place, gazesFor(field.things));
      }
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
      return betweenAnchors(said, peers);
    }
    const Referents& anchors = anchorsOf(said.anchors.front());
    if (anchors.empty()) {
      return {};  // of something the map does not have
    }
    if (said.relation == Relation::kFar) {
      return likelihoodsFarFrom(scene_, peers, anchors);
    }
    return toAnchors(said.relation, peers, anchors, isSettled(phrase(said.anchors.front())));
  }

  /// "The second car on the right", to somebody on the way: of those on that side, the second that one comes to.
  bool isBesideTheWay(const Constraint& said) const {
    const bool is_side = said.place == Placement::kLeft || said.place == Placement::kRight;
    return is_side && said.ranked && from_ && !request_.view && !said.word.starts_with("from");
  }

  std::vector<double> likelihoodsBesideTheWay(const Constraint& said, const Peers& peers) const {
    const Vec2 ahead(std::cos(from_->yaw), std::sin(from_->yaw));
    const Vec2 side = said.place == Placement::kLeft ? leftOf(ahead) : Vec2(-leftOf(ahead));
    Peers beside{peers.things, {}};
    std::vector<double> nearness;
    for (std::size_t i = 0; i < peers.things.size(); ++i) {
      const Vec2 apart = thing(peers.things[i]).centre.head<2>() - Vec2(from_->x, from_->y);
      beside.is_peer.push_back(peers.is_peer[i] && apart.dot(side) > 0 && apart.dot(ahead) > 0);
      nearness.push_back(-apart.norm());
    }
    std::vector<double> likelihoods = likelihoodOfRank(nearness, beside, said);
    for (std::size_t i = 0; i < likelihoods.size(); ++i) {
      likelihoods[i] *= beside.is_peer[i] ? 1 : kWrongSide;
    }
    return likelihoods;
  }

  /// Whether the words for a thing single it out, by what everybody can see of it: "the tallest".
  static bool isSettled(const Phrase& p) {
    return std::ranges::any_of(
        p.constraints, [](const Constraint& c) { return c.kind == Constraint::Kind::kMeasure && c.is_superlative; });
  }

  std::vector<double> toAnchors(Relation relation, const Peers& peers, const Referents& anchors, bool is_settled) {
    return likelihoodsTo(scene_, relation, peers, anchors, is_settled, [&](const SceneThing& anchor) {
      std::vector<Gaze> gazes = gazesSaid({peers.things.begin(), peers.things.end()}, anchor.centre.head<2>());
      return directionsOf(relation, gazes.empty() ? gazesAtFront(scene_, anchor) : std::move(gazes));
    });
  }

  std::vector<double> betweenAnchors(const Constraint& said, const Peers& peers) {
    const Referents a = anchorsOf(said.anchors.front());
    const bool is_pair = said.anchors.size() > 1;
    const Referents b = is_pair ? anchorsOf(said.anchors[1]) : a;
    const bool single = !is_pair && phrase(said.anchors.front()).count < 2 && a.size() < 2;
    if (a.empty() || b.empty() || single) {  // "in the middle of the couch"
      const Referents& known = a.empty() ? b : a;
      return known.empty() ? std::vector<double>{} : toAnchors(Relation::kNear, peers, known, false);
    }
    return likelihoodsBetween(scene_, peers.things, a, b, is_pair);
  }

  std::vector<double> likelihoodsToRobot(const Constraint& said, const Field& field, const Peers& peers) {
    if (!from_) {  // nobody stands anywhere: nearest to who looks is what is in front
      Constraint place;
      place.kind = Constraint::Kind::kPlace;
      place.place = said.relation == Relation::kFar ? Placement::kBack : Placement::kFront;
      return request_.view ? likelihoodOfPlace(scene_, peers, place, gazesFor(field.things)) : std::vector<double>{};
    }
    SceneThing robot;
    robot.id = -1, robot.centre = Vec3(from_->x, from_->y, scene_.low.z()), robot.half = kRobotHalf;
    // One's own left is that of where one looks, one's front too.
    const Vec2 ahead(std::cos(from_->yaw), std::sin(from_->yaw));
    const bool turns = said.relation == Relation::kLeft || said.relation == Relation::kRight;
    const std::vector<Gaze> directions = directionsOf(said.relation, {{turns ? ahead : Vec2(-ahead), 1}});
    return likelihoodsToOne(scene_, said.relation, peers, robot, directions);
  }

  /// How one looks, where the request or the standpoint says it.
  std::vector<Gaze> gazesSaid(const std::vector<int>& things, const Vec2& at) {
    std::vector<Gaze> gazes;
    if (request_.view) {
      const int seen = request_.view->phrase;
      gazes = gazesOfView(scene_, request_.view->kind, seen >= 0 ? anchorsOf(seen) : doorsOf(scene_), things);
    }
    return gazes.empty() && from_ ? gazesFrom(*from_, at) : gazes;
  }

  /// How one looks at things that are told apart among their like.
  std::vector<Gaze> gazesFor(const std::vector<int>& things) {
    std::vector<Gaze> gazes = gazesSaid(things, middleOf(scene_, things));
    return gazes.empty() ? gazesAt(scene_, things) : gazes;
  }

  const Request& request_;
  const QueryScene& scene_;
  const std::optional<Standpoint>& from_;
  std::vector<Referents> anchors_;
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
