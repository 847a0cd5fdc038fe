#include "problems/io/programs/language_words.h"

#include <set>
#include <sstream>

namespace sagitta {
namespace {

// From the vendors' manuals: the instructions of RAPID with those of its arc, spot, dispense, conveyor and sensor
// options that are motions here, its key words, and its types, which begin the lines of a RECORD. What a list lacks is
// named as a routine of another file, which is no harm; a routine that is called as a word of a list goes unnamed.
constexpr char kRapidSyntax[] =
    "ALIAS AND BACKWARD BREAK CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE "
    "ENDPROC ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT EXITCYCLE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE "
    "NOSTEPIN NOT NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY RETURN STEP STOP SYSMODULE TASK TEST THEN TO "
    "TRAP TRYNEXT UNDO VAR VIEWONLY WHILE WITH XOR";
constexpr char kRapidTypes[] =
    "AIOTRIGG ARCDATA BOOL BTNRES BUSSTATE BUTTONDATA BYTE CAMERADEV CAMERATARGET CFGDOMAIN CLOCK CONFDATA "
    "CORRDESCR DATAPOS DIONUM DIR DNUM EGMIDENT ERRDOMAIN ERRNUM ERRSTR ERRTYPE EXTJOINT GUNDATA HANDLER_TYPE "
    "ICONDATA IDENTNO INTNUM IODEV JOINTTARGET LISTITEM LOADDATA LOADIDNUM LOADSESSION MECUNIT MOTSETDATA NUM "
    "OPCALC OPNUM ORIENT O_JOINTTARGET O_ROBTARGET PATHRECID POS POSE PROGDISP RAWBYTES RESTARTDATA RMQHEADER "
    "RMQMESSAGE RMQSLOT ROBJOINT ROBTARGET SEAMDATA SENSOR SHAPEDATA SIGNALAI SIGNALAO SIGNALDI SIGNALDO SIGNALGI "
    "SIGNALGO SOCKETDEV SOCKETSTATUS SPEEDDATA SPOTDATA STOPPOINTDATA STRING STRINGDIG SWITCH SYMNUM SYNCIDENT "
    "TASKID TASKS TESTSIGNAL TOOLDATA TPNUM TRACKDATA TRAPDATA TRIGGDATA TRIGGIOS TRIGGIOSDNUM TRIGGSTRGO "
    "TUNETYPE UISHOWNUM WEAVEDATA WELDDATA WOBJDATA WZSTATIONARY WZTEMPORARY ZONEDATA";
constexpr char kRapidInstructions[] =
    "ACCSET ACTEVENTBUFFER ACTUNIT ADD ALIASIO ALIASIORESET BITCLEAR BITSET BOOKERRNO BRAKECHECK CALLBYVAR "
    "CANCELLOAD CHECKPROGREF CIRPATHMODE CLEAR CLEARIOBUFF CLEARPATH CLEARRAWBYTES CLKRESET CLKSTART CLKSTOP "
    "CLOSE CLOSEDIR CONFJ CONFL COPYFILE COPYRAWBYTES CORRCLEAR CORRCON CORRDISCON CORRWRITE DEACTEVENTBUFFER "
    "DEACTUNIT DECR DITHERACT DITHERDEACT DROPSENSOR DROPWOBJ EGMACTJOINT EGMACTMOVE EGMACTPOSE EGMGETID EGMRESET "
    "EGMSETUPAI EGMSETUPAO EGMSETUPGI EGMSETUPUC EGMSTOP EOFFSOFF EOFFSON EOFFSSET ERASEMODULE ERRLOG ERRRAISE "
    "ERRWRITE FRICIDEVALUATE FRICIDINIT FRICIDSETFRICLEVELS GETDATAVAL GETSYSDATA GETTRAPDATA GRIPLOAD "
    "HOLLOWWRISTRESET ICAP IDELETE IDISABLE IENABLE IERROR INCR INDAMOVE INDCMOVE INDDMOVE INDRESET INDRMOVE "
    "INVERTDO IOBUSSTART IOBUSSTATE IODISABLE IOENABLE IPATHPOS IPERS IRMQMESSAGE ISIGNALAI ISIGNALAO ISIGNALDI "
    "ISIGNALDO ISIGNALGI ISIGNALGO ISLEEP ITIMER IVARVALUE IWATCH LOAD LOADID MAKEDIR MANLOADIDPROC MECHUNITLOAD "
    "MOTIONPROCESSMODESET MOTIONSUP MTOOLROTCALIB MTOOLTCPCALIB OPEN OPENDIR PACKDNHEADER PACKRAWBYTES PATHACCLIM "
    "PATHRECMOVEBWD PATHRECMOVEFWD PATHRECSTART PATHRECSTOP PATHRESOL PDISPOFF PDISPON PDISPSET PROCERRRECOVERY "
    "PULSEDO RAISETOUSER READANYBIN READBLOCK READCFGDATA READERRDATA READRAWBYTES REMOVEALLCYCLICBOOL "
    "REMOVECYCLICBOOL REMOVEDIR REMOVEFILE RENAMEFILE RESET RESETAXISMOVETIME RESETPPMOVED RESETRETRYCOUNT "
    "RESTOPATH REWIND RMQEMPTYQUEUE RMQFINDSLOT RMQGETMESSAGE RMQGETMSGDATA RMQGETMSGHEADER RMQREADWAIT "
    "RMQSENDMESSAGE RMQSENDWAIT SAVE SAVECFGDATA SCWRITE SENDEVICE SET SETALLDATAVAL SETAO SETDATASEARCH "
    "SETDATAVAL SETDO SETGO SETLEADTHROUGH SETSYSDATA SETUPCYCLICBOOL SICLOSE SICONNECT SIGETCYCLIC SINGAREA "
    "SISETCYCLIC SKIPWARN SOCKETACCEPT SOCKETBIND SOCKETCLOSE SOCKETCONNECT SOCKETCREATE SOCKETLISTEN "
    "SOCKETRECEIVE SOCKETRECEIVEFROM SOCKETSEND SOCKETSENDTO SOFTACT SOFTDEACT SPEEDLIMAXIS SPEEDLIMCHECKPOINT "
    "SPEEDREFRESH SPYSTART SPYSTOP STARTLOAD STARTMOVE STARTMOVERETRY STCALIB STCLOSE STEPBWDPATH STINDGUN "
    "STINDGUNRESET STOOLROTCALIB STOOLTCPCALIB STOPEN STOPMOVE STOPMOVERESET STOREPATH STTUNE STTUNERESET "
    "SUPSYNCSENSOROFF SUPSYNCSENSORON SYNCMOVEOFF SYNCMOVEON SYNCMOVERESUME SYNCMOVESUSPEND SYNCMOVEUNDO "
    "SYNCTOSENSOR SYSTEMSTOPACTION TESTSIGNDEFINE TESTSIGNRESET TEXTTABINSTALL TPERASE TPREADDNUM TPREADFK "
    "TPREADNUM TPSHOW TPWRITE TRIGGCHECKIO TRIGGDATACOPY TRIGGDATARESET TRIGGEQUIP TRIGGINT TRIGGIO TRIGGRAMPAO "
    "TRIGGSPEED TRIGGSTOPPROC TRYINT TUNERESET TUNESERVO UIMSGBOX UIMSGWRITE UIMSGWRITEABORT UISHOW UNLOAD "
    "UNPACKRAWBYTES VELSET WAITAI WAITAO WAITDI WAITDO WAITGI WAITGO WAITLOAD WAITROB WAITSENSOR WAITSYNCTASK "
    "WAITTESTANDSET WAITTIME WAITUNTIL WAITWOBJ WARMSTART WORLDACCLIM WRITE WRITEANYBIN WRITEBIN WRITEBLOCK "
    "WRITECFGDATA WRITERAWBYTES WRITESTRBIN WRITEVAR WZBOXDEF WZCYLDEF WZDISABLE WZDOSET WZENABLE WZFREE "
    "WZHOMEJOINTDEF WZLIMJOINTDEF WZLIMSUP WZSPHDEF";
constexpr char kRapidMotions[] =
    "ARCC ARCC1 ARCC1END ARCC1START ARCC2 ARCC2END ARCC2START ARCCEND ARCCSTART ARCL ARCL1 ARCL1END ARCL1START "
    "ARCL2 ARCL2END ARCL2START ARCLEND ARCLSTART ARCMOVEEXTJ ARCREFRESH CAPC CAPL DISPC DISPL EGMMOVEC EGMMOVEL "
    "EGMRUNJOINT EGMRUNPOSE MOVEABSJ MOVEC MOVECAO MOVECDO MOVECGO MOVECSYNC MOVEEXTJ MOVEJ MOVEJAO MOVEJDO "
    "MOVEJGO MOVEJSYNC MOVEL MOVELAO MOVELDO MOVELGO MOVELSYNC NUTJ NUTL PAINTC PAINTL SEARCHC SEARCHEXTJ SEARCHL "
    "SPOTJ SPOTL SPOTMJ SPOTML TRIGGABSJ TRIGGC TRIGGJ TRIGGJIOS TRIGGL TRIGGLIOS";

// Functions of the script manual, those of the controller's own log and register interfaces included.
constexpr char kUrSyntax[] =
    "and assert break continue def elif else end enter_critical exit_critical for global halt if join kill local "
    "not or return run sec sync thread while xor";
constexpr char kUrMotions[] =
    "conveyor_pulse_decode direct_torque encoder_enable_pulse_decode encoder_enable_set_tick_count "
    "encoder_get_tick_count encoder_set_tick_count encoder_unwind_delta_tick_count end_force_mode "
    "end_freedrive_mode end_screw_driving end_teach_mode force_mode force_mode_set_damping "
    "force_mode_set_gain_scaling freedrive_mode freedrive_mode_no_incorrect_payload_check get_conveyor_tick_count "
    "get_freedrive_status get_target_tcp_pose_along_path get_target_tcp_speed_along_path movec movej movel movep "
    "optimovej optimovel path_offset_disable path_offset_enable path_offset_get path_offset_set "
    "path_offset_set_alpha_filter path_offset_set_max_offset pause_on_error_code position_deviation_warning "
    "reset_revolution_counter screw_driving servoc servoj servop set_conveyor_tick_count set_pos "
    "set_safety_mode_transition_hardness speedj speedl stop_conveyor_tracking stopj stopl teach_mode "
    "track_conveyor_circular track_conveyor_linear";
constexpr char kUrState[] =
    "force get_actual_joint_positions get_actual_joint_positions_history get_actual_joint_speeds "
    "get_actual_tcp_pose get_actual_tcp_speed get_actual_tool_flange_pose get_controller_temp get_forward_kin "
    "get_inverse_kin get_inverse_kin_has_solution get_joint_temp get_joint_torques get_steptime "
    "get_target_joint_accelerations get_target_joint_positions get_target_joint_speeds get_target_payload "
    "get_target_payload_cog get_target_payload_inertia get_target_tcp_pose get_target_tcp_speed "
    "get_target_waypoint get_tcp_force get_tcp_offset get_tool_accelerometer_reading get_tool_current is_steady "
    "is_within_safety_limits popup powerdown protective_stop request_boolean_from_primary_client "
    "request_float_from_primary_client request_integer_from_primary_client request_string_from_primary_client "
    "set_base_acceleration set_gravity set_payload set_payload_cog set_payload_mass set_target_payload set_tcp "
    "sleep str_at str_cat str_empty str_find str_len str_sub textmsg to_num to_str tool_contact varmsg";
constexpr char kUrMath[] =
    "abs acos asin atan atan2 binary_list_to_integer ceil cos d2r floor get_list_length integer_to_binary_list "
    "interpolate_pose inv length log make_list norm normalize point_dist pose_add pose_dist pose_inv pose_sub "
    "pose_trans pow r2d random rotvec2rpy rpy2rotvec sin size sqrt tan transpose wrench_trans";
constexpr char kUrInterfaces[] =
    "enable_external_ft_sensor ft_rtde_input_enable get_analog_in get_analog_out get_configurable_digital_in "
    "get_configurable_digital_out get_digital_in get_digital_out get_euromap_input get_euromap_output get_flag "
    "get_standard_analog_in get_standard_analog_out get_standard_digital_in get_standard_digital_out "
    "get_tool_analog_in get_tool_digital_in get_tool_digital_out modbus_add_signal modbus_delete_signal "
    "modbus_get_signal_status modbus_send_custom_command modbus_set_digital_input_action "
    "modbus_set_output_register modbus_set_output_signal modbus_set_runstate_dependent_choice "
    "modbus_set_signal_update_frequency read_input_boolean_register read_input_float_register "
    "read_input_integer_register read_output_boolean_register read_output_float_register "
    "read_output_integer_register read_port_bit read_port_register rpc_factory rtde_set_watchdog "
    "set_analog_inputrange set_analog_out set_analog_outputdomain set_configurable_digital_input_action "
    "set_configurable_digital_out set_digital_out set_euromap_output set_euromap_runstate_dependent_choice "
    "set_flag set_gp_boolean_input_action set_input_actions_to_default "
    "set_runstate_configurable_digital_output_to_value set_runstate_gp_boolean_output_to_value "
    "set_runstate_standard_analog_output_to_value set_runstate_standard_digital_output_to_value "
    "set_runstate_tool_digital_output_to_value set_standard_analog_input_domain set_standard_analog_out "
    "set_standard_digital_input_action set_standard_digital_out set_tool_analog_input_domain "
    "set_tool_communication set_tool_digital_input_action set_tool_digital_out set_tool_digital_output_mode "
    "set_tool_output_mode set_tool_voltage socket_close socket_get_var socket_open socket_read_ascii_float "
    "socket_read_binary_integer socket_read_byte_list socket_read_line socket_read_string socket_send_byte "
    "socket_send_int socket_send_line socket_send_string socket_set_var write_output_boolean_register "
    "write_output_float_register write_output_integer_register write_port_bit write_port_register zero_ftsensor";

// What a bracket may follow; of routines those of the controller that set no base and move nothing.
constexpr char kKrlWords[] =
    "BAS CASE CCLOSE CIOCTL CIRC COPEN CREAD CWRITE FOR IF IR_STOPM LIN LOOP MSGDIALOG MSGLOOP MSGNOTIFY MSGQUIT "
    "MSGSTATE PTP PULSE REPEAT RETURN SCIRC SIGNAL SLIN SPL SPTP SREAD SWITCH SWRITE UNTIL WAIT WHILE";

// First words of statements that have no sign and no square bracket.
constexpr char kFanucWords[] =
    "ABORT BREAK CALL COL DETECT ELSE END ENDFOR ENDIF FOR IF JMP LOCK MONITOR OFFSET PAUSE RESUME_PROG RETURN "
    "RUN SELECT SKIP STOP_TRACKING TOOL_OFFSET UNLOCK WAIT WEAVE";

using Words = std::set<std::string>;

Words SplitWords(std::initializer_list<const char*> lists) {
  Words words;
  for (const char* list : lists) {
    std::istringstream stream(list);
    for (std::string word; stream >> word;) words.insert(word);
  }
  return words;
}

}  // namespace

const Words& KrlWords() {
  static const Words kWords = SplitWords({kKrlWords});
  return kWords;
}

const Words& RapidWords() {
  static const Words kWords = SplitWords({kRapidSyntax, kRapidTypes, kRapidInstructions, kRapidMotions});
  return kWords;
}

const Words& UrScriptWords() {
  static const Words kWords = SplitWords({kUrSyntax, kUrMotions, kUrState, kUrMath, kUrInterfaces});
  return kWords;
}

const Words& FanucWords() {
  static const Words kWords = SplitWords({kFanucWords});
  return kWords;
}

}  // namespace sagitta
