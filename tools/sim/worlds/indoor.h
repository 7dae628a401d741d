#pragma once

#include "sim/worlds/stage.h"

namespace hgg {

/// Label ids of firmware_cfg/indoor/classes.toml.
enum class Indoor : ClassId {
  kWall = 1,
  kFloor = 2,
  kCeiling = 3,
  kDoor = 4,
  kWindow = 5,
  kStairs = 6,
  kPillar = 7,
  kChair = 10,
  kTable = 11,
  kDesk = 12,
  kSofa = 13,
  kBed = 14,
  kShelf = 15,
  kCabinet = 16,
  kBench = 17,
  kCounter = 18,
  kMonitor = 20,
  kLamp = 21,
  kPlant = 22,
  kBin = 23,
  kBox = 24,
  kPicture = 25,
  kSink = 26,
  kToilet = 27,
  kFridge = 28,
  kTicketMachine = 29,
  kPerson = 30,
  kSign = 31
};

/// What is to be known of an object of the class.
WorldObject objectOf(Indoor label);

/// Furniture in local coordinates: origin on the floor below its middle, x ahead (its back is towards -x). Sizes in m.
Shapes chairShapes(Dice& dice);
Shapes officeChairShapes(Dice& dice);
Shapes tableShapes(double length, double width);
Shapes deskShapes(double length);
/// Stands at height `z`.
Shapes monitorShapes(Dice& dice, double z);
Shapes sofaShapes(double length);
Shapes bedShapes(double width);
Shapes shelfShapes(double length, double height);
Shapes cabinetShapes(Dice& dice);
Shapes indoorBenchShapes(double length);
Shapes counterShapes(double length);
Shapes lampShapes(Dice& dice);
Shapes plantShapes(Dice& dice);
Shapes wasteBinShapes(Dice& dice);
Shapes boxShapes(Dice& dice);
/// On a wall behind it, its middle at height `z`.
Shapes pictureShapes(double length, double height, double z);
Shapes sinkShapes();
Shapes toiletShapes();
Shapes fridgeShapes();
Shapes ticketMachineShapes();
Shapes standeeShapes(Dice& dice);

/// A hole in a wall: `at` m along it, from `bottom` to `top`.
struct Opening {
  double at, width, bottom, top;
};
Opening doorway(double at);
Opening windowAt(double at, double width);

/// A rectangle between walls.
struct Room {
  Vec2 lo, hi;
  Vec2 center() const { return 0.5 * (lo + hi); }
};

/// A building under construction: `Stage` with walls.
class House {
 public:
  House(Stage& stage, Dice& dice, double ceiling) : stage_(stage), dice_(dice), ceiling_(ceiling) {}

  /// Floor and ceiling over a rectangle.
  void addFloor(const Vec2& lo, const Vec2& hi);
  /// A straight wall; windows (openings with a sill) get panes.
  void addWall(const Vec2& from, const Vec2& to, std::vector<Opening> openings);
  /// A door leaf hung in the doorway at `at` m along the wall from -> to, turned by `angle` out of the wall to the
  /// left.
  void addDoor(const Vec2& from, const Vec2& to, double at, double angle);
  /// Tells the truth that these rectangles are one room.
  void nameRoom(const std::string& name, const std::vector<Room>& parts);

 private:
  Stage& stage_;
  Dice& dice_;
  double ceiling_;
};

/// Puts furniture into rooms where there is room: off the ways, off other furniture.
class Furnisher {
 public:
  Furnisher(Stage& stage, Dice& dice, double dynamics) : stage_(stage), dice_(dice), dynamics_(dynamics) {}

  /// With its back to a wall of the room; wall: 0 south, 1 east, 2 north, 3 west, any other: whichever fits. The spot
  /// it got, nullopt when there was none.
  std::optional<Spot> againstWall(const Room& room, Indoor label, const Shapes& shapes, int wall = -1,
                                  double gap = 0.25);
  std::optional<Spot> inside(const Room& room, Indoor label, const Shapes& shapes, double gap = 0.4);
  /// On a wall, above the furniture.
  void hang(const Room& room, Indoor label, const Shapes& shapes, int wall = -1);
  void tableWithChairs(const Room& room, double length, double width);
  /// A desk at a wall with a monitor, a chair, sometimes a lamp.
  void workplace(const Room& room);

 private:
  bool put(Indoor label, const Shapes& shapes, const Spot& spot, double gap);
  /// Between the laps some of what is light is moved a little.
  void mayBeMoved(std::size_t object, const Shapes& shapes, const Spot& spot);
  /// Whether the shapes at the spot are between the room's walls.
  bool fits(const Room& room, const Shapes& shapes, const Spot& spot) const;
  Spot atWall(const Room& room, const Shapes& shapes, int wall);

  Stage& stage_;
  Dice& dice_;
  double dynamics_;
};

}  // namespace hgg
