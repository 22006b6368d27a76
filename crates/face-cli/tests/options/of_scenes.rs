//! What a scene says of its fits, and options in its place.

use super::*;

#[test]
fn what_fits_see_and_weigh_stands_in_the_scene_and_options_replace_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = with_targets(at);
    let text = std::fs::read_to_string(at.join("scene.json")).unwrap();
    let said =
        r#""fit": { "points": "both", "landmark_weight": 9, "jaw_weight_mm2": 0 }, "material""#;
    let own = text.replacen("\"material\"", said, 1);
    std::fs::write(at.join("scene.json"), own).unwrap();
    let mut fit = Fit::default_of(&scene);
    fit.seen = Observed::Both {
        landmark_weight: 9.0,
    };
    fit.params.joint_weight = 0.0;
    let both = fit.of_first(&scene);
    let one = ["--target", "first"];
    assert_eq!(fits(at, &one), std::slice::from_ref(&both));
    // The distance that is told is that of landmarks; the skin's stands beside it.
    let told = |seen: Observed| {
        let mut only = Fit::default_of(&scene);
        only.seen = seen;
        only.of_first(&scene)["rms_before_mm"].clone()
    };
    assert_eq!(both["rms_before_mm"], told(Observed::Landmarks));
    assert_eq!(both["dense"]["rms_before_mm"], told(Observed::Dense));
    assert_ne!(both["rms_before_mm"], both["dense"]["rms_before_mm"]);
    let plain = Fit::default_of(&scene).of_first(&scene);
    assert_ne!(both["rms_after_mm"], plain["rms_after_mm"]);
    let options = ["--points", "landmarks", "--jaw-weight", "300"];
    assert_eq!(fits(at, &[&one[..], &options].concat()), [plain]);
    let settings = &report(at, "fit", &one).1["settings"];
    assert_eq!(
        [
            &settings["points"],
            &settings["landmark_weight"],
            &settings["jaw_weight_mm2"]
        ],
        [&Value::from("both"), &Value::from(9.0), &Value::from(0.0)]
    );
    // A table of landmarks knows no skin: what the scene weighs beside one does not hold.
    std::fs::copy(at.join("targets.csv"), at.join("others.csv")).unwrap();
    let others = report(at, "fit", &["--targets", "others.csv", "--target", "first"]).1;
    let plain = Fit::default_of(&scene).of_first(&scene);
    let (found, expected) = (
        &others["results"]["fits"][0]["activations"],
        &plain["activations"],
    );
    assert_eq!(found, expected);
    assert_eq!(others["settings"]["points"], "landmarks");
    assert_eq!(others["settings"]["jaw_weight_mm2"], 300.0);
}
