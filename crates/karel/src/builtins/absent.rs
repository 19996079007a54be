//! Built-ins of options and devices that this controller does not have.
//!
//! A program that names one is translated, with a warning; who calls it gets what a controller without that option says.

use super::{Builtin, Context, Outcome, Returns};
use crate::{machine::fault::Fault, status::Status};

/// A built-in that is not there, and what it would need.
pub(crate) struct Absent {
    pub(crate) builtin: Builtin,
    pub(crate) needs: &'static str,
}

const FORMS: &str = "forms and menus of the pendant's screen";
const VISION: &str = "a camera";
const PC: &str = "the PC interface";
const PIPES: &str = "data acquisition";
const XML: &str = "the XML parser";
const KCL: &str = "the KCL command language";
const FILES: &str = "positions in files";
const PROGRAMS: &str = "backups of programs";
const PORTS: &str = "serial ports and I/O modules";
const CLOCK: &str = "a clock that can be set";
const OTHERS: &str = "what is not simulated";

/// Arguments are not compared with a signature.
const fn row(name: &'static str, returns: Returns, needs: &'static str) -> Absent {
    let builtin = Builtin {
        name,
        params: &[],
        required: 0,
        returns,
        code: absent,
    };
    Absent { builtin, needs }
}

const fn procedure(name: &'static str, needs: &'static str) -> Absent {
    row(name, Returns::Nothing, needs)
}

static TABLE: &[Absent] = &[
    procedure("ACT_TBL", FORMS),
    procedure("ADD_BYNAMEPC", PC),
    procedure("ADD_INTPC", PC),
    procedure("ADD_REALPC", PC),
    procedure("ADD_STRINGPC", PC),
    procedure("DAQ_CHECKP", PIPES),
    procedure("DAQ_REGPIPE", PIPES),
    procedure("DAQ_START", PIPES),
    procedure("DAQ_STOP", PIPES),
    procedure("DAQ_UNREG", PIPES),
    procedure("DAQ_WRITE", PIPES),
    procedure("DISCTRL_ALPH", FORMS),
    procedure("DISCTRL_FORM", FORMS),
    procedure("DISCTRL_LIST", FORMS),
    procedure("DISCTRL_PLMN", FORMS),
    procedure("DISCTRL_SBMN", FORMS),
    procedure("DISCTRL_TBL", FORMS),
    procedure("DOSFILE_INF", FILES),
    procedure("FORCE_LINK", FORMS),
    row("GET_FILE_POS", Returns::Integer, FILES),
    row("GET_PORT_ATR", Returns::Integer, PORTS),
    procedure("INIT_TBL", FORMS),
    procedure("IO_MOD_TYPE", PORTS),
    procedure("KCL", KCL),
    procedure("KCL_NO_WAIT", KCL),
    row("KCL_STATUS", Returns::Integer, KCL),
    row("MIRROR", Returns::XyzwprExt, OTHERS),
    procedure("MOVE_FILE", FILES),
    procedure("PIPE_CONFIG", FILES),
    procedure("PROG_BACKUP", PROGRAMS),
    procedure("PROG_CLEAR", PROGRAMS),
    procedure("PROG_RESTORE", PROGRAMS),
    procedure("QUEUE_ATTACH", PC),
    procedure("READ_DICT_V", FORMS),
    procedure("RENAME_VARS", PROGRAMS),
    procedure("RMCN_ALERT", PC),
    procedure("RMCN_SEND", PC),
    procedure("SEND_DATAPC", PC),
    procedure("SEND_EVENTPC", PC),
    procedure("SET_FILE_POS", FILES),
    procedure("SET_PERCH", OTHERS),
    row("SET_PORT_ATR", Returns::Integer, PORTS),
    procedure("SET_TIME", CLOCK),
    procedure("SET_TSK_ATTR", OTHERS),
    procedure("SET_TSK_NAME", OTHERS),
    procedure("VOL_SPACE", FILES),
    procedure("VREG_FND_POS", VISION),
    procedure("VREG_OFFSET", VISION),
    procedure("V_ACQ_VAMAP", VISION),
    procedure("V_CAM_CALIB", VISION),
    procedure("V_CLR_VAMAP", VISION),
    procedure("V_DISPLAY4D", VISION),
    procedure("V_FIND_VIEW", VISION),
    procedure("V_GET_OFFSET", VISION),
    procedure("V_GET_PASSFL", VISION),
    procedure("V_GET_VPARAM", VISION),
    procedure("V_IRCONNECT", VISION),
    procedure("V_LED_OFF", VISION),
    procedure("V_LED_ON", VISION),
    procedure("V_OVERRIDE", VISION),
    procedure("V_RUN_FIND", VISION),
    procedure("V_SAVE_IMREG", VISION),
    procedure("V_SET_REF", VISION),
    procedure("V_SNAP_VIEW", VISION),
    procedure("XML_ADDTAG", XML),
    procedure("XML_GETDATA", XML),
    procedure("XML_REMTAG", XML),
    procedure("XML_SCAN", XML),
    procedure("XML_SETVAR", XML),
];

/// Looks one up by its upper-case name.
pub(crate) fn find(name: &str) -> Option<&'static Absent> {
    TABLE.iter().find(|absent| absent.builtin.name == name)
}

/// ASSUMPTION: as `MSG_CONNECT` without its option, which users report.
fn absent(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let name = context.site.builtin.name;
    let needs = find(name).map_or(OTHERS, |absent| absent.needs);
    let message = format!("Undefined built-in: {name} needs {needs}");
    Err(Fault::new(Status::INTP_UNDEFINED_BUILTIN, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_absent_is_not_there_under_the_same_name() {
        for absent in TABLE {
            let name = absent.builtin.name;
            assert!(super::super::find(name).is_none(), "{name} is there");
        }
    }
}
