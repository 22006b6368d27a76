//! AnisoMPM: anisotropic damage, QR elasticity and inextensible fibres on a material-point host
