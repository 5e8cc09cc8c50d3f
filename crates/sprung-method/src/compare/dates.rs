//! Dates in words.

/// Seconds in a day.
pub(super) const SECONDS_PER_DAY: f64 = 86_400.0;

/// Days from the first of March of the year 0 to the first of January 1970, in the Gregorian calendar.
const DAYS_TO_1970: i64 = 719_468;

/// Days in 400 years.
const DAYS_IN_ERA: i64 = 146_097;

/// Returns the day of a time as `2026-01-31`.
///
/// - `time_s`: s since 1970.
///
/// # Source
///
/// Howard Hinnant, "chrono-compatible low-level date algorithms": `civil_from_days`.
pub(super) fn day(time_s: f64) -> String {
    let days = (time_s / SECONDS_PER_DAY).floor() as i64;
    let days = days.saturating_add(DAYS_TO_1970);
    let (era, of_era) = (days.div_euclid(DAYS_IN_ERA), days.rem_euclid(DAYS_IN_ERA));
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let from_march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * from_march + 2) / 5 + 1;
    // A year begins in March here.
    let month = if from_march < 10 {
        from_march + 3
    } else {
        from_march - 9
    };
    let year = year + 400 * era + i64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

/// Returns a time in minutes as `2026-01-31 17:05`, in the time zone of the log.
///
/// - `time_s`: s since 1970.
pub(super) fn minute(time_s: f64) -> String {
    let minutes = (time_s.rem_euclid(SECONDS_PER_DAY) / 60.0).floor();
    format!(
        "{} {:02}:{:02}",
        day(time_s),
        (minutes / 60.0).floor(),
        minutes % 60.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_of_the_calendar() {
        // `date -u -d @… +%F`.
        for (time, date) in [
            (0.0, "1970-01-01"),
            (951_782_400.0, "2000-02-29"),
            (951_868_800.0, "2000-03-01"),
            (1_709_251_199.0, "2024-02-29"),
            (1_767_225_599.0, "2025-12-31"),
            (1_767_225_600.0, "2026-01-01"),
            (4_102_444_799.0, "2099-12-31"),
        ] {
            assert_eq!(day(time), date);
        }
        assert_eq!(minute(1_767_225_599.9), "2025-12-31 23:59");
        assert_eq!(minute(1_714_564_800.123), "2024-05-01 12:00");
    }
}
