#include "problems/io/programs/calls_elsewhere.h"

#include <algorithm>
#include <set>

#include "problems/io/pattern.h"

namespace sagitta {
namespace {

struct CallsOf {
  std::regex call;      // group 1: the name
  std::regex routine;   // group 1: the name of one that is in the file
  std::regex language;  // names of the language
};

const CallsOf& Calls(ProgramDialect dialect) {
  static const CallsOf krl = {
      MakeCodePattern("(?:\\n|\\bDO) ?([A-Z_]\\w*) ?\\("),
      MakeCodePattern("\\bDEF(?:FCT \\w+(?:\\[[^\\]]{0,20}\\])?)? (\\w+)"),
      MakeCodePattern(
          "^(?:BAS|IF|WHILE|UNTIL|SWITCH|WAIT|RETURN|CASE|FOR|IR_STOPM|C(?:OPEN|CLOSE|READ|WRITE|IOCTL)|SREAD|"
          "SWRITE|PULSE|LOOP|REPEAT|MSG\\w*|SIGNAL|PTP|LIN|CIRC|SPTP|SLIN|SCIRC|SPL)$")};
  static const CallsOf rapid = {
      MakeCodePattern("(?:;|[^,=+*/\\\\(\\[{-]\\n|\\b(?:THEN|ELSE|DO|:)) ?\\n?([A-Z_]\\w*) ?\\n?(?=;|\\\\|[ \\n]\\w)"),
      MakeCodePattern("\\b(?:PROC|TRAP|FUNC \\w+) (\\w+)"),
      MakeCodePattern(
          "^(?:(?:LOCAL|TASK|VAR|PERS|CONST|ALIAS|RECORD|ENDRECORD|MODULE|ENDMODULE|PROC|FUNC|TRAP|END\\w*|IF|THEN|"
          "ELSE|"
          "ELSEIF|FOR|WHILE|TEST|CASE|DEFAULT|DO|GOTO|RETURN|RAISE|RETRY|TRYNEXT|EXIT|EXITCYCLE|BREAK|STOP|STOPMOVE|"
          "STARTMOVE|ERROR|UNDO|BACKWARD|CONNECT|AND|OR|NOT|XOR|DIV|MOD|RESET|INCR|DECR|ADD|CLEAR|OPEN|CLOSE|REWIND|"
          "GRIPLOAD|ACCSET|VELSET|SINGAREA|NUM|BOOL|STRING|POS|ORIENT|POSE|ROBTARGET|JOINTTARGET|TOOLDATA|WOBJDATA|"
          "LOADDATA|SPEEDDATA|ZONEDATA|CLOCK|INTNUM|BYTE|DNUM)|(?:MOVE|TRIGG|SEARCH|ARC|SPOT|DISP|CONF|PDISP|EOFFS|TP|"
          "UI|WAIT|SET|PULSE|INVERT|CLK|ERR|SOCKET|WRITE|READ|IDELETE|IWATCH|ISLEEP|IENABLE|IDISABLE|ISIGNAL|ITIMER|"
          "IPERS|IERROR|PATH|MOTION|SOFT|WORLD|WZ|RESTOPATH|STOREPATH|CLEARPATH|LOAD|UNLOAD|CORR|PACK|UNPACK)\\w*)$")};
  static const CallsOf ur = {
      MakeCodePattern("(?:\\n|;|:|\\brun\\b) ?\\n?([A-Za-z_]\\w*) ?\\("),
      MakeCodePattern("\\b(?:def|thread|sec) (\\w+)"),
      MakeCodePattern(
          "^(?:if|elif|while|return|and|or|not|assert|sleep|sync|popup|halt|textmsg|global|local|join|kill|run|"
          "(?:move|optimove|servo|speed|stop|set_|get_|is_|socket_|rtde_|modbus_|write_|read_|force_|end_|"
          "freedrive|enter_|exit_|zero_|conveyor|encoder|tool_|reset_|step|path_|teach_|track_|stop_|"
          "position_|request_|screw|varmsg|str_|to_|rpc)\\w*)$")};
  static const CallsOf fanuc = {MakeCodePattern("\\b(?:CALL|RUN) ([A-Z_]\\w*)"), MakeCodePattern("/PROG (\\w+)"),
                                MakeCodePattern("^$")};
  switch (dialect) {
    case ProgramDialect::kKrl:
      return krl;
    case ProgramDialect::kRapid:
      return rapid;
    case ProgramDialect::kUrScript:
      return ur;
    case ProgramDialect::kFanuc:
      break;
  }
  return fanuc;
}

}  // namespace

void FindCallsElsewhere(const ProgramCode& code, RobotProgram* program) {
  const CallsOf& of = Calls(program->dialect);
  const std::string& text = code.text();
  std::set<std::string> own;
  for (const std::smatch& match : AllMatches(text.begin(), text.end(), of.routine)) own.insert(match[1]);
  for (auto from = text.begin();;) {
    std::smatch match;
    if (!SearchPattern(from, text.end(), &match, of.call)) break;
    const size_t at = static_cast<size_t>(match[1].first - text.begin());
    from = match[1].second;
    const std::string name = match[1];
    if (own.count(name) > 0 || MatchPattern(name, of.language)) continue;
    program->calls_elsewhere.emplace(name, code.LineAt(at));
  }
}

}  // namespace sagitta
