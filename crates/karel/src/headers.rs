//! The header files that every controller has, in our own words and with our own numbers.
//!
//! ASSUMPTION: programs use the names. The numbers are ours, except the two window codes and the lamps
//! of the operator panel, which sources in the field tell.

use std::fmt::Write as _;

use crate::port::Port;

/// The text of a header, by the last part of its path in lower case.
pub(crate) fn text(stem: &str) -> Option<String> {
    let constants: &[(&str, i32)] = match stem {
        "klevccdf" => &[
            ("cc_clear_win", 128),
            ("cc_clear_eol", 129),
            ("cc_clear_eow", 130),
            ("cc_cr", 13),
            ("cc_lf", 10),
            ("cc_up", 134),
            ("cc_down", 135),
            ("cc_right", 136),
            ("cc_home", 137),
            ("cc_blink", 138),
            ("cc_reverse", 139),
            ("cc_bold", 140),
            ("cc_under", 141),
            ("cc_normal", 143),
            ("cc_bgcolor", 200),
            ("cc_fgcolor", 201),
            ("cc_black", 210),
            ("cc_red", 211),
            ("cc_green", 212),
            ("cc_yellow", 213),
            ("cc_blue", 214),
            ("cc_magenta", 215),
            ("cc_cyan", 216),
            ("cc_white", 217),
            ("cc_dfcolor", 218),
        ],
        "klevkeys" => &[
            ("ky_prev", 128),
            ("ky_f1", 129),
            ("ky_f2", 131),
            ("ky_f3", 132),
            ("ky_f4", 133),
            ("ky_f5", 134),
            ("ky_next", 135),
            ("ky_select", 143),
            ("ky_menus", 144),
            ("ky_edit", 145),
            ("ky_data", 146),
            ("ky_fctn", 147),
            ("ky_shift", 173),
            ("ky_reset", 140),
            ("ky_step", 141),
            ("ky_hold", 142),
            ("ky_fwd", 148),
            ("ky_bwd", 149),
            ("ky_enter", 13),
            ("ky_up_arw", 212),
            ("ky_dn_arw", 213),
            ("ky_rt_arw", 208),
            ("ky_lf_arw", 209),
            ("ky_new_menu", 250),
            ("ky_undef", 251),
        ],
        "klevkmsk" => &[
            ("kc_display", 1),
            ("kc_func_key", 2),
            ("kc_keypad", 4),
            ("kc_enter_key", 8),
            ("kc_delete", 16),
            ("kc_lr_arw", 32),
            ("kc_ud_arw", 64),
            ("kc_other", 128),
        ],
        "kliosop" => &[
            ("sopo_remote", 0),
            ("sopo_cycle", 1),
            ("sopo_held", 2),
            ("sopo_fault", 3),
            ("sopo_batalm", 4),
            ("sopo_user1", 5),
            ("sopo_user2", 6),
            ("sopo_tpenbl", 7),
        ],
        "klrdutil" => &[],
        "kliotyps" => {
            let mut text = "CONST\n".to_owned();
            for (port, number) in Port::ALL.iter().zip(1..) {
                let name = port.name().to_ascii_lowercase();
                let _ = writeln!(text, "  io_{name} = {number}");
            }
            return Some(text);
        }
        _ => return None,
    };
    let mut text = "CONST\n".to_owned();
    for (name, value) in constants {
        let _ = writeln!(text, "  {name} = {value}");
    }
    Some(text)
}
